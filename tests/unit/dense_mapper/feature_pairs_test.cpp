#include <lcmslam/dense_mapper/thesis/feature_pairs.hpp>

#include <gtest/gtest.h>

#include "tests/unit/dense_mapper/gallery.hpp"

namespace lcmslam {
namespace {

// A tenth of the features shows other things that happen to look alike.
TEST(FeaturePairs, CheckedOnesAgreeOnOneMotion) {
  Gallery gallery(3);
  const Eigen::Isometry3d T_target_source = se3_exp(twist(0.1, 0.05, 0, 0, 0.05, 0));
  const FeatureFrame target = gallery.seen_from(Eigen::Isometry3d::Identity()).features;
  FeatureFrame source = gallery.seen_from(T_target_source).features;
  for (std::size_t i = 0; i < source.features.size(); i += 10)
    source.features[i].point += Eigen::Vector3f(0.3f, -0.2f, 0.4f);

  const auto farthest = [&](const FeaturePairs& pairs) {
    float distance = 0;
    for (std::size_t i = 0; i < pairs.source.size(); ++i)
      distance =
          std::max(distance, (T_target_source.cast<float>() * pairs.source[i] - pairs.target[i]).norm());
    return distance;
  };
  const FeaturePairs all = feature_pairs(source, target, false);
  const FeaturePairs checked = feature_pairs(source, target, true);
  EXPECT_GT(farthest(all), 0.4f);
  EXPECT_LT(farthest(checked), 0.03f);
  EXPECT_GT(checked.source.size(), all.source.size() * 8 / 10);
  EXPECT_EQ(checked.source.size(), checked.target.size());
}

}  // namespace
}  // namespace lcmslam
