// Which of several starts is right: the clouds say.

#include <gtest/gtest.h>

#include <lcmslam/dense_mapper/start_hypotheses.hpp>
#include <lcmslam/registration/kd_tree_target.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

const Eigen::Isometry3d T_target_source = se3_exp(twist(0.5, -0.3, 0.1, 0.1, -0.1, 0.6));

Cloud moved_room() {
  return transformed(room(0.037), T_target_source.inverse());
}

Hypothesis start_at(const Eigen::Isometry3d& T, const char* origin, double information = 0) {
  return {{T, information * Matrix6d::Identity()}, origin};
}

void expect_right(const Eigen::Isometry3d& T, double metres) {
  EXPECT_LT((T_target_source.inverse() * T).translation().norm(), metres);
}

TEST(StartHypotheses, TheCloudsFindTheRightOneInAnyOrder) {
  const KdTreeTarget target(room(0.03));
  const Hypothesis right = start_at(T_target_source * se3_exp(twist(0.05, 0.03, 0, 0, 0.03, 0)), "right");
  const Hypothesis wrong = start_at(Eigen::Isometry3d::Identity(), "wrong");
  for (const auto& order : {std::vector<Hypothesis>{right, wrong}, std::vector<Hypothesis>{wrong, right}}) {
    const auto best = register_hypotheses(moved_room(), target, order);
    EXPECT_EQ(best.origin, "right");
    EXPECT_GT(best.score, 0.8);
    EXPECT_TRUE(best.registration.ok());
    expect_right(best.registration.T_target_source, 0.005);
  }
}

TEST(StartHypotheses, NothingToTryIsNoResult) {
  const KdTreeTarget target(room());
  const auto none = register_hypotheses(room(), target, {});
  EXPECT_FALSE(none.registration.ok());
  EXPECT_EQ(none.score, 0);
  const auto empty = register_hypotheses({}, target, {start_at(Eigen::Isometry3d::Identity(), "identity")});
  EXPECT_FALSE(empty.registration.ok());
}

// In front of a bare wall the knowledge that comes with the start holds what the clouds leave free.
TEST(StartHypotheses, KnowledgeHoldsWhatSlides) {
  const KdTreeTarget target(wall(0.03));
  const Eigen::Isometry3d start = se3_exp(twist(0.02, 0.1, -0.1, 0, 0.02, 0));
  const auto best = register_hypotheses(wall(0.04), target, {start_at(start, "SURF", 1e4)});
  ASSERT_TRUE(best.registration.ok());
  EXPECT_NEAR(best.registration.T_target_source.translation().y(), 0.1, 0.01);
  EXPECT_NEAR((best.registration.T_target_source * Eigen::Vector3d(2, 0, 0)).x(), 2, 0.005);
}

FeatureFrame features_of(const Cloud& cloud, std::uint64_t seed) {
  Random random(seed);
  FeatureFrame frame;
  frame.width = 640, frame.height = 480;
  frame.fx = frame.fy = 500, frame.cx = 320, frame.cy = 240;
  for (std::size_t i = 0; i < cloud.size(); i += 200) {
    Feature f;
    f.laplacian = 1;
    f.kind = MeasurementKind::point;
    f.point = cloud.points[i] + Eigen::Vector3f::Constant(static_cast<float>(random.normal(0, 0.002)));
    if (!(f.point.z() > 0.3f)) continue;
    f.depth_sigma = 0.004f;
    Random own(i);
    for (auto& byte : f.descriptor) byte = static_cast<std::uint8_t>(own.below(256));
    frame.features.push_back(f);
  }
  return frame;
}

TEST(StartHypotheses, SurfProposesOnceWhatBothRatiosFind) {
  const Eigen::Isometry3d ahead = optical_axes().inverse();  // so that the room lies before the camera
  const Cloud seen = transformed(room(0.037), ahead);
  const Eigen::Isometry3d T = se3_exp(twist(0.1, -0.1, 0.1, 0.05, 0.1, 0.05));
  const auto proposed = surf_hypotheses(features_of(transformed(seen, T.inverse()), 1), features_of(seen, 2));
  ASSERT_EQ(proposed.size(), 1U);
  const Eigen::Isometry3d error = T.inverse() * proposed[0].prior.T_target_source;
  EXPECT_LT(error.translation().norm(), 0.02);
  EXPECT_LT(rotation_angle(error), 0.02);
  EXPECT_TRUE(surf_hypotheses({}, features_of(seen, 2)).empty());
}

}  // namespace
}  // namespace lcmslam
