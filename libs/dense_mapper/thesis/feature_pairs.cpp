#include <lcmslam/dense_mapper/thesis/feature_pairs.hpp>

#include <lcmslam/features/matching.hpp>
#include <lcmslam/features/rigid_ransac.hpp>

namespace lcmslam {

FeaturePairs feature_pairs(const FeatureFrame& source, const FeatureFrame& target, bool checked) {
  std::vector<Match> matches = match(target.features, source.features);
  if (checked) {
    Random random(1);
    std::vector<Match> believed;
    for (const int i : align_ransac(target, source, matches, {}, random).inliers)
      believed.push_back(matches[static_cast<std::size_t>(i)]);
    matches = believed;
  }
  FeaturePairs pairs;
  for (const Match& m : matches) {
    const Feature& a = target.features[static_cast<std::size_t>(m.a)];
    const Feature& b = source.features[static_cast<std::size_t>(m.b)];
    if (a.kind != MeasurementKind::point || b.kind != MeasurementKind::point) continue;
    pairs.target.push_back(a.point);
    pairs.source.push_back(b.point);
  }
  return pairs;
}

}  // namespace lcmslam
