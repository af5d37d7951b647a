#include <lcmslam/dense_mapper/thesis/thesis_tracker.hpp>

#include <cmath>
#include <stdexcept>

#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/registration/view_frustum.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

/// A cloud of the world with the colours of the nearest points that a camera shows.
ColouredCloud painted(const Cloud& cloud, const Eigen::Isometry3d& T_world_camera,
                      const ColouredCloud& colours) {
  constexpr float reach = 0.1F;  // m: more than a voxel's centre is from its points
  const cv::Vec3b grey(128, 128, 128);
  const KdTree tree(colours.points);
  const Eigen::Isometry3f T_camera_world = T_world_camera.inverse().cast<float>();
  ColouredCloud result;
  result.points = cloud.points;
  result.normals = cloud.normals;
  result.sigmas = cloud.sigmas;
  for (const Eigen::Vector3f& p : cloud.points) {
    const int i = tree.nearest(T_camera_world * p, reach).index;
    result.colours.push_back(i < 0 ? grey : colours.colours[static_cast<std::size_t>(i)]);
  }
  return result;
}

}  // namespace

StartKind start_kind(VariantKind variant, const ThesisSettings& settings) {
  if (settings.start != StartKind::by_variant) return settings.start;
  return variant == VariantKind::alternating ? StartKind::features : StartKind::prediction;
}

bool needs_features(VariantKind variant, const ThesisSettings& settings) {
  if (variant == VariantKind::modern) return false;
  return variant == VariantKind::alternating || start_kind(variant, settings) == StartKind::features;
}

ThesisTracker::ThesisTracker(VariantKind kind, const ThesisSettings& settings)
    : kind_(kind), settings_(settings), target_(settings.merge_distance) {
  check(settings, "thesis");
  if (kind == VariantKind::modern)
    throw std::invalid_argument("thesis: variant modern is none of plain, alternating and frustum");
}

Tracked ThesisTracker::track(const PreparedFrame& prepared, const Expectation& expected) {
  Tracked result;
  result.prior = expected.prior;
  result.registration = register_frame(prepared, expected.prior.T_target_source);
  result.quality = result.registration.overlap * inlier_share(result.registration);
  if (result.registration.ok()) result.status = MappingStatus::tracking;
  return result;
}

RegistrationResult ThesisTracker::register_frame(const PreparedFrame& prepared,
                                                 const Eigen::Isometry3d& T_predicted) const {
  const Eigen::Isometry3d T_start = start_of(prepared, T_predicted);
  RegistrationResult result = kind_ == VariantKind::alternating ? register_by_turns(prepared, T_start)
                              : kind_ == VariantKind::frustum   ? register_in_view(prepared, T_start)
                                                                : register_plain(prepared.cloud, T_start);
  const Eigen::Matrix3d R = result.T_target_source.linear();
  if (R.determinant() > 0.1) {
    result.T_target_source.linear() = Eigen::Quaterniond(R).normalized().toRotationMatrix();
  } else {
    result.T_target_source = T_predicted;
    result.stop = StopReason::degenerate;
  }
  return result;
}

Eigen::Isometry3d ThesisTracker::start_of(const PreparedFrame& prepared,
                                          const Eigen::Isometry3d& T_predicted) const {
  switch (start_kind(kind_, settings_)) {
    case StartKind::features:  // 3, 4 of algorithm 3.2
      return align_start(surf_pairs(prepared.frame), settings_.icp.registration).value_or(T_predicted);
    case StartKind::last_pose:
      return T_world_robot_;
    default:
      return T_predicted;
  }
}

// Algorithm 3.1.
RegistrationResult ThesisTracker::register_plain(const Cloud& cloud, const Eigen::Isometry3d& T_start) const {
  RegistrationSettings icp = settings_.icp.registration;
  icp.epsilon_rms = settings_.icp.epsilon_rms;
  icp.epsilon_translation = icp.epsilon_rotation = 0;
  return register_cloud(cloud, target_, T_start, icp);
}

// Frustum ICP: the source is moved by odometry, and what the last depth camera could not see is left out.
RegistrationResult ThesisTracker::register_in_view(const PreparedFrame& prepared,
                                                   const Eigen::Isometry3d& T_start) const {
  if (!colour_) return register_plain(prepared.cloud, T_start);
  const Eigen::Isometry3d T_world_last = T_world_camera_ * colour_->T_camera_depth;
  const ViewFrustum last(colour_->depth_camera);
  return register_plain(points_inside(prepared.cloud, last, T_world_last.inverse() * T_start), T_start);
}

// Algorithm 3.2; steps as there. 3 and 4 are start_of().
RegistrationResult ThesisTracker::register_by_turns(const PreparedFrame& prepared,
                                                    const Eigen::Isometry3d& T_start) const {
  const Cloud sub = seen_by_both(prepared);                                             // 1
  const FeaturePairs surf = surf_pairs(prepared.frame);                                 // 2
  const auto turns = register_alternating(sub, target_, surf, T_start, settings_.icp);  // 5-10
  RegistrationResult result = look(sub, target_, turns.T_target_source, settings_.icp.registration);
  result.rms = turns.from_features ? turns.feature_rms : turns.cloud_rms;
  if (result.stop == StopReason::converged || turns.from_features) result.stop = turns.stop;
  return result;
}

// S_sub: without two images of one kind all points.
Cloud ThesisTracker::seen_by_both(const PreparedFrame& prepared) const {
  const DenseFrame& frame = prepared.frame;
  if (!frame.colour || !colour_ || frame.colour->image.size() != colour_->image.size() ||
      frame.colour->image.type() != colour_->image.type())
    return prepared.cloud;
  const ImageOverlap overlap = colour_overlap(frame.colour->image, colour_->image, settings_.overlap);
  return overlapping_points(prepared.cloud, overlap, frame.colour->camera, frame.T_robot_camera.inverse());
}

// S_SURF in the robot's frame, T_SURF in the world's.
FeaturePairs ThesisTracker::surf_pairs(const DenseFrame& frame) const {
  if (!frame.features || !features_) return {};
  FeaturePairs pairs = feature_pairs(*frame.features, *features_, settings_.checked_features);
  for (auto& p : pairs.source) p = (frame.T_robot_camera * p.cast<double>()).cast<float>();
  for (auto& p : pairs.target) p = (T_world_camera_ * p.cast<double>()).cast<float>();
  return pairs;
}

void ThesisTracker::accept(const PreparedFrame& prepared, const Eigen::Isometry3d& T_world_robot,
                           bool /*registered*/) {
  const DenseFrame& frame = prepared.frame;
  const std::size_t fresh = target_.add(transformed(prepared.cloud, T_world_robot));
  T_world_robot_ = T_world_robot;
  T_world_camera_ = T_world_robot * frame.T_robot_camera;
  joined_ = painted(target_.newest(fresh), T_world_camera_,
                    frame.colouriser ? frame.colouriser() : ColouredCloud());
  features_ = frame.features;
  colour_.reset();
  if (frame.colour && !frame.colour->image.empty()) colour_ = frame.colour;
}

}  // namespace lcmslam
