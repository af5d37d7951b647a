#include <lcmslam/odometry/visual_odometry.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

FeatureFrame with_points_only(FeatureFrame frame) {
  const auto has_no_point = [](const Feature& feature) {
    return feature.kind != MeasurementKind::point || !feature.point.allFinite() ||
           !std::isfinite(feature.depth_sigma);
  };
  auto& features = frame.features;
  features.erase(std::remove_if(features.begin(), features.end(), has_no_point), features.end());
  return frame;
}

Matrix6d diagonal(double translation_sigma, double rotation_sigma) {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(translation_sigma * translation_sigma),
      Eigen::Vector3d::Constant(rotation_sigma * rotation_sigma);
  return variance.asDiagonal();
}

}  // namespace

VisualOdometry::VisualOdometry(const VisualOdometrySettings& settings, Random random)
    : settings_(settings), random_(random) {
  check(settings_, "visual odometry");
}

std::optional<MotionSample> VisualOdometry::update(const FeatureFrame& all_features) {
  FeatureFrame frame = with_points_only(all_features);
  if (keyframes_.empty() || frame.utime < sample_.utime) {
    start(frame);
    return keyframes_.empty() ? std::nullopt : std::optional(sample_);
  }
  if (frame.utime == sample_.utime) return std::nullopt;

  report_ = {};
  std::vector<const Reference*> references;
  for (const Reference& keyframe : keyframes_) references.push_back(&keyframe);
  auto alignment = align(references, frame);
  const bool to_keyframes = alignment.has_value();
  if (!alignment && previous_) alignment = align({&*previous_}, frame);

  if (!alignment) {
    predict(frame.utime);
    // Whatever the keyframes showed is gone: go on from here.
    if (report_.status == VisualStatus::lost && has_enough_points(frame)) {
      keyframes_.clear();
      add_keyframe(frame);
    }
    return sample_;
  }
  accept(*alignment, frame.utime);
  Reference& newest = keyframes_.back();
  if (to_keyframes && newest.first_inliers == 0) newest.first_inliers = alignment->newest_inliers;
  // A frame that is aligned badly (blurred) would hand its error on.
  const bool is_good = report_.inliers >= 2 * settings_.ransac.min_inliers && has_enough_points(frame);
  if (is_good && (!to_keyframes || newest_keyframe_is_worn(*alignment))) add_keyframe(frame);
  previous_ = Reference{std::move(frame), alignment->T_odom_camera, 0};
  return sample_;
}

void VisualOdometry::start(const FeatureFrame& frame) {
  keyframes_.clear();
  previous_.reset();
  report_ = {};
  sample_ = MotionSample{};
  sample_.utime = aligned_utime_ = frame.utime;
  sample_.visual = true;
  T_odom_aligned_ = sample_.T_odom_robot;
  velocity_.setZero();
  if (has_enough_points(frame)) {
    add_keyframe(frame);
    report_.status = VisualStatus::tracking;
  } else {
    report_.reason = std::to_string(frame.features.size()) + " features with depth; a first keyframe needs " +
                     std::to_string(2 * settings_.ransac.min_inliers);
  }
}

// All references at once: their points in the odometry frame against the frame's in the camera's.
VisualOdometry::Pairs VisualOdometry::match(const std::vector<const Reference*>& references,
                                            const FeatureFrame& frame) {
  Pairs result;
  for (const Reference* reference : references) {
    result.newest_begin = result.pairs.size();
    const Eigen::Matrix3d R = reference->T_odom_camera.linear();
    for (const Match& m : matcher_.match(reference->frame.features, frame.features, settings_.matching)) {
      const Feature& a = reference->frame.features[static_cast<std::size_t>(m.a)];
      const Feature& b = frame.features[static_cast<std::size_t>(m.b)];
      result.pairs.push_back({reference->T_odom_camera * a.point.cast<double>(), b.point.cast<double>(),
                              R * point_covariance(a, reference->frame) * R.transpose(),
                              point_covariance(b, frame)});
    }
  }
  return result;
}

VisualOdometry::Pairs VisualOdometry::Pairs::near(const Eigen::Isometry3d& T_odom_camera,
                                                  double within) const {
  Pairs result;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (i == newest_begin) result.newest_begin = result.pairs.size();
    if ((pairs[i].point_a - T_odom_camera * pairs[i].point_b).norm() < within)
      result.pairs.push_back(pairs[i]);
  }
  if (newest_begin == pairs.size()) result.newest_begin = result.pairs.size();
  return result;
}

std::optional<VisualOdometry::Alignment> VisualOdometry::align(
    const std::vector<const Reference*>& references, const FeatureFrame& frame) {
  const Pairs all = match(references, frame);
  const double within = settings_.expected_within;
  Pairs asked = all.near(expected(frame.utime) * frame.T_robot_camera, within);
  RigidRansacResult result = align_ransac(asked.pairs, settings_.ransac, random_);
  // What was expected shall not have chosen: then all that is seen where it should be from there.
  if (Pairs found = result.success ? all.near(result.T_a_b, within) : all;
      !result.success || found.pairs.size() > asked.pairs.size()) {
    asked = std::move(found);
    result = align_ransac(asked.pairs, settings_.ransac, random_);
  }
  report_.matches = static_cast<int>(all.pairs.size());
  report_.inliers = static_cast<int>(result.inliers.size());
  if (!result.success) {
    report_.reason = result.reason;
    return std::nullopt;
  }

  Alignment alignment;
  alignment.T_odom_camera = result.T_a_b;
  alignment.T_odom_robot = result.T_a_b * frame.T_robot_camera.inverse();
  const Matrix6d A = adjoint(frame.T_robot_camera);
  alignment.covariance = A * result.covariance * A.transpose();
  alignment.newest_inliers =
      static_cast<int>(std::count_if(result.inliers.begin(), result.inliers.end(), [&](int i) {
        return static_cast<std::size_t>(i) >= asked.newest_begin;
      }));

  const Eigen::Isometry3d T_step = T_odom_aligned_.inverse() * alignment.T_odom_robot;
  const double seconds = seconds_since_aligned(frame.utime);
  if (T_step.translation().norm() > settings_.max_speed * seconds ||
      rotation_angle(T_step) > settings_.max_turn_rate * seconds) {
    report_.reason = "the alignment moves faster than max_speed or max_turn_rate";
    return std::nullopt;
  }
  return alignment;
}

void VisualOdometry::accept(const Alignment& alignment, Utime utime) {
  const double seconds = seconds_since_aligned(utime);
  velocity_ = se3_log(T_odom_aligned_.inverse() * alignment.T_odom_robot) / seconds;

  Matrix6d Q = settings_.covariance_factor * alignment.covariance +
               diagonal(settings_.translation_floor, settings_.rotation_floor);
  const Vector6d shift = settings_.stamp_sigma * velocity_;
  Q += shift * shift.transpose();
  // The newest sample was a prediction: the step away from it has its error, too.
  if (sample_.utime != aligned_utime_) Q += prediction_covariance(seconds_since_aligned(sample_.utime));
  add_step(alignment.T_odom_robot, Q);

  sample_.utime = aligned_utime_ = utime;
  T_odom_aligned_ = alignment.T_odom_robot;
  report_.status = VisualStatus::tracking;
  report_.reason.clear();
}

// Where the last velocity leads.
Eigen::Isometry3d VisualOdometry::expected(Utime utime) const {
  return T_odom_aligned_ *
         se3_exp(std::min(seconds_since_aligned(utime), settings_.max_prediction) * velocity_);
}

void VisualOdometry::predict(Utime utime) {
  const double before = seconds_since_aligned(sample_.utime);
  const double now = seconds_since_aligned(utime);
  add_step(expected(utime), prediction_covariance(now) - prediction_covariance(before) +
                                diagonal(settings_.translation_floor, settings_.rotation_floor));
  sample_.utime = utime;
  report_.status = now > settings_.max_prediction ? VisualStatus::lost : VisualStatus::degraded;
}

void VisualOdometry::add_step(const Eigen::Isometry3d& T_odom_robot, const Matrix6d& Q) {
  const Matrix6d A = adjoint(T_odom_robot.inverse() * sample_.T_odom_robot);
  const Matrix6d S = A * sample_.covariance * A.transpose() + Q;
  sample_.covariance = 0.5 * (S + S.transpose());
  sample_.T_odom_robot = T_odom_robot;
}

bool VisualOdometry::newest_keyframe_is_worn(const Alignment& alignment) const {
  const Reference& newest = keyframes_.back();
  const Eigen::Isometry3d T_keyframe_camera = newest.T_odom_camera.inverse() * alignment.T_odom_camera;
  return alignment.newest_inliers < settings_.keyframe_inlier_ratio * newest.first_inliers ||
         T_keyframe_camera.translation().norm() > settings_.keyframe_translation ||
         rotation_angle(T_keyframe_camera) > settings_.keyframe_rotation;
}

void VisualOdometry::add_keyframe(const FeatureFrame& frame) {
  keyframes_.push_back({frame, sample_.T_odom_robot * frame.T_robot_camera, 0});
  if (keyframes_.size() > static_cast<std::size_t>(settings_.keyframes)) keyframes_.pop_front();
  report_.new_keyframe = true;
}

bool VisualOdometry::has_enough_points(const FeatureFrame& frame) const {
  return static_cast<int>(frame.features.size()) >= 2 * settings_.ransac.min_inliers;
}

// Beyond 1 rad a rotation is unknown and a wider normal distribution says no more. Nobody goes faster than
// max_speed, and what grows with the square of an hour leaves no digits for what is known after it.
Matrix6d VisualOdometry::prediction_covariance(double seconds) const {
  const double half_square = 0.5 * seconds * seconds;
  return diagonal(std::min(settings_.max_speed * seconds, settings_.prediction_acceleration * half_square),
                  std::min(1.0, settings_.prediction_turn_acceleration * half_square));
}

double VisualOdometry::seconds_since_aligned(Utime utime) const {
  return 1e-6 * static_cast<double>(utime - aligned_utime_);
}

}  // namespace lcmslam
