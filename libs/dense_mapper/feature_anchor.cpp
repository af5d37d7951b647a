#include <lcmslam/dense_mapper/feature_anchor.hpp>

#include <algorithm>
#include <iterator>

#include <lcmslam/dense_mapper/by_node.hpp>
#include <lcmslam/pose_graph/pose_graph.hpp>

namespace lcmslam {
namespace {

std::vector<PointPair> seen_near(const std::vector<PointPair>& pairs, const Eigen::Isometry3d& T_world_camera,
                                 double within) {
  std::vector<PointPair> near;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(near), [&](const PointPair& pair) {
    return (T_world_camera * pair.point_b - pair.point_a).norm() < within;
  });
  return near;
}

}  // namespace

FeatureAnchor::FeatureAnchor(const FeatureAnchorSettings& settings) : settings_(settings) {}

void FeatureAnchor::add(const Eigen::Isometry3d& T_world_camera, const FeatureFrame& features, int node) {
  keyframes_.push_back({T_world_camera, features, node});
}

void FeatureAnchor::deform(const std::vector<Eigen::Isometry3d>& T_new_old) {
  for (Keyframe& keyframe : keyframes_)
    keyframe.T_world_camera = of_node(T_new_old, keyframe.node) * keyframe.T_world_camera;
}

void FeatureAnchor::renumber(const std::vector<bool>& gone, const std::vector<int>& number) {
  keyframes_.erase(std::remove_if(keyframes_.begin(), keyframes_.end(),
                                  [&](const Keyframe& k) { return gone[static_cast<std::size_t>(k.node)]; }),
                   keyframes_.end());
  for (Keyframe& keyframe : keyframes_) keyframe.node = number[static_cast<std::size_t>(keyframe.node)];
}

std::size_t FeatureAnchor::memory_bytes() const {
  std::size_t bytes = keyframes_.capacity() * sizeof(Keyframe);
  for (const Keyframe& keyframe : keyframes_)
    bytes += keyframe.features.features.capacity() * sizeof(Feature);
  return bytes;
}

std::vector<const FeatureAnchor::Keyframe*> FeatureAnchor::around(
    const Eigen::Isometry3d& T_world_camera) const {
  std::vector<std::pair<double, const Keyframe*>> near;
  for (const Keyframe& keyframe : keyframes_) {
    const Eigen::Isometry3d step = keyframe.T_world_camera.inverse() * T_world_camera;
    const double distance = step.translation().norm() / settings_.max_distance;
    const double angle = rotation_angle(step) / settings_.max_angle;
    if (distance < 1 && angle < 1) near.emplace_back(distance + angle, &keyframe);
  }
  std::sort(near.begin(), near.end());
  std::vector<const Keyframe*> nearest;
  for (const auto& [distance, keyframe] : near)
    if (nearest.size() < static_cast<std::size_t>(settings_.keyframes)) nearest.push_back(keyframe);
  return nearest;
}

std::optional<Prior> FeatureAnchor::locate(const FeatureFrame& features,
                                           const Eigen::Isometry3d& T_world_camera,
                                           const Eigen::Isometry3d& T_robot_camera) {
  const std::vector<PointPair> pairs = matches(around(T_world_camera), features);
  const auto place = agreed(seen_near(pairs, T_world_camera, settings_.expected_within), T_robot_camera,
                            settings_.min_inliers);
  if (!place) return agreed(pairs, T_robot_camera, 2 * settings_.min_inliers, settings_.recognised_share);
  // Once more by all that is seen where it should be from there: what was expected shall not have chosen.
  const Eigen::Isometry3d T_found = place->T_target_source * T_robot_camera;
  const auto again =
      agreed(seen_near(pairs, T_found, settings_.expected_within), T_robot_camera, settings_.min_inliers);
  return again ? again : place;
}

std::optional<Prior> FeatureAnchor::recognise(const FeatureFrame& features,
                                              const Eigen::Isometry3d& T_world_camera,
                                              const Eigen::Isometry3d& T_robot_camera) {
  return agreed(matches(around(T_world_camera), features), T_robot_camera, 2 * settings_.min_inliers,
                settings_.recognised_share);
}

// Of those that are seen, no more than a half are found again.
bool FeatureAnchor::is_rich(const FeatureFrame& features) const {
  const auto points = std::count_if(features.features.begin(), features.features.end(),
                                    [](const Feature& f) { return f.kind == MeasurementKind::point; });
  return points >= 4 * settings_.min_inliers;
}

bool FeatureAnchor::can_recognise(const FeatureFrame& features,
                                  const Eigen::Isometry3d& T_world_camera) const {
  if (keyframes_.empty() || !is_rich(features)) return false;
  const std::vector<const Keyframe*> near = around(T_world_camera);
  return near.empty() ||
         std::any_of(near.begin(), near.end(), [&](const Keyframe* k) { return is_rich(k->features); });
}

std::optional<Prior> FeatureAnchor::search(const FeatureFrame& features,
                                           const Eigen::Isometry3d& T_robot_camera) {
  for (int i = 0; i < settings_.searched_keyframes && !keyframes_.empty(); ++i) {
    const Keyframe& keyframe = keyframes_[next_search_++ % keyframes_.size()];
    if (const auto found = agreed(matches({&keyframe}, features), T_robot_camera, settings_.min_inliers))
      return found;
  }
  return std::nullopt;
}

// All keyframes' matches at once, in the world: where one keyframe gives way to the next, nothing jumps.
std::vector<PointPair> FeatureAnchor::matches(const std::vector<const Keyframe*>& keyframes,
                                              const FeatureFrame& features) {
  std::vector<PointPair> pairs;
  for (const Keyframe* keyframe : keyframes) {
    const Eigen::Matrix3d R = keyframe->T_world_camera.linear();
    for (const Match& m : matcher_.match(keyframe->features.features, features.features)) {
      const Feature& known = keyframe->features.features[static_cast<std::size_t>(m.a)];
      const Feature& seen = features.features[static_cast<std::size_t>(m.b)];
      if (known.kind != MeasurementKind::point || seen.kind != MeasurementKind::point) continue;
      pairs.push_back({keyframe->T_world_camera * known.point.cast<double>(), seen.point.cast<double>(),
                       R * point_covariance(known, keyframe->features) * R.transpose(),
                       point_covariance(seen, features)});
    }
  }
  return pairs;
}

std::optional<Prior> FeatureAnchor::agreed(const std::vector<PointPair>& pairs,
                                           const Eigen::Isometry3d& T_robot_camera, int min_inliers,
                                           double min_share) const {
  RigidRansacSettings ransac;
  ransac.min_inliers = min_inliers;
  Random random(1);
  const RigidRansacResult aligned = align_ransac(pairs, ransac, random);
  if (!aligned.success ||
      static_cast<double>(aligned.inliers.size()) < min_share * static_cast<double>(pairs.size()))
    return std::nullopt;
  Matrix6d covariance = aligned.covariance;
  covariance.diagonal().head<3>().array() += settings_.floor_translation * settings_.floor_translation;
  covariance.diagonal().tail<3>().array() += settings_.floor_rotation * settings_.floor_rotation;
  const Matrix6d A = adjoint(T_robot_camera);  // from the camera's body frame to the robot's
  Prior anchor;
  anchor.T_target_source = aligned.T_a_b * T_robot_camera.inverse();
  anchor.information = (A * covariance * A.transpose()).inverse();
  return anchor;
}

double disagreement(const Prior& a, const Prior& b) {
  return distance_from_identity(
      {a.T_target_source.inverse() * b.T_target_source, a.information.inverse() + b.information.inverse()});
}

Prior fused(const Prior& a, const Prior& b) {
  // First order about a: b lies at xi from there, in a's body frame.
  const Vector6d xi = se3_log(a.T_target_source.inverse() * b.T_target_source);
  Prior result;
  result.information = a.information + b.information;
  result.T_target_source = a.T_target_source * se3_exp(result.information.ldlt().solve(b.information * xi));
  return result;
}

}  // namespace lcmslam
