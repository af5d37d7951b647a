#include <lcmslam/dense_mapper/motion_prior.hpp>

#include <Eigen/Dense>
#include <algorithm>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {
namespace {

constexpr double longest_velocity = 1;  // s that a velocity goes on
constexpr double drift_speed = 0.5;     // m/s and rad/s of a robot that nobody watches

Vector6d squares(double translation, double rotation) {
  Vector6d v;
  v.head<3>().setConstant(translation * translation);
  v.tail<3>().setConstant(rotation * rotation);
  return v;
}

constexpr double least = 0.1;  // of the floor, whatever odometry says

// Wheels that do not turn do not slip: else what moves before a robot that stands takes it along.
double share_of_floor(const Motion& motion) {
  constexpr double step = 0.005;  // m or rad, from which on all of the floor is there
  if (motion.visual) return 1;
  const double moved = motion.T_from_to.translation().norm() + rotation_angle(motion.T_from_to);
  return std::clamp(moved / step, least, 1.0);
}

// The floor of a step lies along the ground as odometry's own error does: a base whose tyres hold it sideways
// slips along its way.
Matrix6d floor_of_step(const Motion& motion, double share, const MotionPriorSettings& settings) {
  const Matrix6d& odometry = motion.covariance;
  Matrix6d floor = squares(share * settings.floor_translation, share * settings.floor_rotation).asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(odometry.topLeftCorner<2, 2>());
  const Eigen::Vector2d& variances = axes.eigenvalues();  // ascending
  if (variances[1] <= 0) return floor;
  const Eigen::Vector2d shares = (variances / variances[1]).cwiseMax(least * least);
  floor.topLeftCorner<2, 2>() *= axes.eigenvectors() * shares.asDiagonal() * axes.eigenvectors().transpose();
  return floor;
}

Matrix6d drift_after(double seconds) {
  return squares(drift_speed * seconds, std::min(drift_speed * seconds, 3.0)).asDiagonal();
}

bool is_usable(const std::optional<Motion>& motion) {
  return motion && motion->T_from_to.matrix().allFinite() && motion->covariance.allFinite();
}

// What is uncertain before a motion, as seen from the place after it.
Matrix6d carried_along(const Matrix6d& covariance, const Motion& motion) {
  const Matrix6d A = adjoint(motion.T_from_to.inverse());
  return A * covariance * A.transpose();
}

}  // namespace

Matrix6d uncertain(const Prior& prior) {
  return (prior.information + 1e-6 * Matrix6d::Identity()).inverse();
}

Prior predict(const Eigen::Isometry3d& T_world_last, const std::optional<Motion>& motion,
              const Eigen::Isometry3d& free_motion, const MotionPriorSettings& settings, double adrift,
              Floor floor, const UnseenWay& unseen) {
  Prior prior;
  Matrix6d covariance = Matrix6d::Zero();
  if (is_usable(motion)) {
    prior.T_target_source = T_world_last * motion->T_from_to;
    const double slip = std::max(share_of_floor(*motion), unseen.slip);
    covariance = motion->covariance + floor_of_step(*motion, slip, settings) +
                 carried_along(unseen.covariance, *motion);
  } else {
    prior.T_target_source = T_world_last * free_motion;
    covariance.diagonal() = squares(settings.free_translation, settings.free_rotation);
  }
  covariance += drift_after(adrift);
  if (!settings.planar || floor == Floor::free) {
    prior.information = covariance.inverse();
    return prior;
  }

  // On the ground x, y and heading are what motion tells; tilt is known absolutely, and on the plane the
  // height.
  const bool on_plane = floor == Floor::plane;
  prior.T_target_source = on_plane ? on_ground(prior.T_target_source) : levelled(prior.T_target_source);
  const int in_plane[3] = {0, 1, 5};
  Eigen::Matrix3d moving;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) moving(i, j) = covariance(in_plane[i], in_plane[j]);
  const Eigen::Matrix3d information = moving.inverse();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) prior.information(in_plane[i], in_plane[j]) = information(i, j);
  prior.information(2, 2) =
      1 / (on_plane ? settings.ground.height * settings.ground.height : covariance(2, 2));
  prior.information(3, 3) = prior.information(4, 4) = 1 / (settings.ground.tilt * settings.ground.tilt);
  return prior;
}

Prior MotionModel::predict(Utime utime, const std::optional<Motion>& motion, Floor floor, bool pushed) const {
  UnseenWay unseen = unseen_;
  if (pushed) unseen.slip = 1;
  return lcmslam::predict(T_world_last_, motion, free_motion(utime), settings_, std::max(unknown_, adrift_),
                          floor, unseen);
}

Prior MotionModel::predict_step(Utime utime, const std::optional<Motion>& motion, Floor floor,
                                bool pushed) const {
  const double unknown = knows(motion) ? 0 : std::max(0.0, seconds_until(utime));
  UnseenWay none;
  if (pushed) none.slip = 1;
  return lcmslam::predict(T_world_last_, motion, free_motion(utime), settings_, unknown, floor, none);
}

bool MotionModel::is_held(const std::optional<Motion>& motion) const {
  return is_usable(motion) && std::max(share_of_floor(*motion), unseen_.slip) < 1;
}

Eigen::Isometry3d MotionModel::free_motion(Utime utime) const {
  return se3_exp(std::clamp(seconds_until(utime), 0.0, longest_velocity) * velocity_);
}

bool MotionModel::knows(const std::optional<Motion>& motion) const {
  if (!is_usable(motion)) return false;
  const Vector6d guess = squares(settings_.free_translation, settings_.free_rotation);
  return !motion->visual || (motion->covariance.diagonal().array() <= guess.array()).all();
}

Matrix6d MotionModel::drift() const {
  return drift_after(adrift_);
}

void MotionModel::look_for_gap(Utime utime, const std::optional<Motion>& motion) {
  const double seconds = seconds_until(utime);
  if (adrift())
    adrift_ += seconds;
  else if (!knows(motion) && unknown_ + seconds > longest_velocity)
    adrift_ = unknown_ + seconds;
}

void MotionModel::found() {
  unknown_ = adrift_ = 0;
  unseen_ = {};
}

void MotionModel::lose(Utime utime, const std::optional<Motion>& motion, bool guided) {
  if (!guided && !knows(motion)) unknown_ += seconds_until(utime);
  if (!is_usable(motion)) return;
  unseen_.covariance = carried_along(unseen_.covariance, *motion) + motion->covariance;
  unseen_.slip = std::max(unseen_.slip, share_of_floor(*motion));
}

void MotionModel::observe(Utime utime, const Eigen::Isometry3d& T_world_robot, bool moving) {
  const double seconds = seconds_until(utime);
  velocity_.setZero();
  if (moving && seconds > 0) velocity_ = se3_log(T_world_last_.inverse() * T_world_robot) / seconds;
  T_world_last_ = T_world_robot;
  last_utime_ = utime;
}

}  // namespace lcmslam
