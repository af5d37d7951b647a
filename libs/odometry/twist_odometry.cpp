#include <lcmslam/odometry/twist_odometry.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr double max_turn_per_step = 0.05;  // rad: a longer arc is cut for its covariance

}  // namespace

TwistOdometry::TwistOdometry(const TwistOdometrySettings& settings) : settings_(settings) {
  check(settings_, "twist odometry");
}

std::optional<MotionSample> TwistOdometry::update(const Twist& twist) {
  if (twist_ && twist.utime == twist_->utime) return std::nullopt;
  if (!twist_ || twist.utime < twist_->utime)
    sample_ = MotionSample{};
  else
    integrate(1e-6 * static_cast<double>(twist.utime - twist_->utime));
  twist_ = twist;
  sample_.utime = twist.utime + std::llround(1e6 * settings_.delay);
  return sample_;
}

void TwistOdometry::integrate(double seconds) {
  const double held = std::min(seconds, settings_.timeout);
  Vector6d way;
  way << held * twist_->linear, held * twist_->angular;
  const double turn = way.tail<3>().norm();
  const int steps = std::clamp(static_cast<int>(std::ceil(turn / max_turn_per_step)), 1, 1000);
  const Vector6d step = way / steps;
  Matrix6d Q =
      increment_covariance(settings_.noise, {step(0), step(1), step(5), step.head<2>().norm(), held / steps});
  Q.diagonal().head<2>().array() += settings_.curve_noise * settings_.curve_noise * turn / steps;
  const Matrix6d A = adjoint(se3_exp(-step));
  for (int i = 0; i < steps; ++i) sample_.covariance = (A * sample_.covariance * A.transpose() + Q).eval();
  constexpr double any_turn = 3;  // rad
  const double unknown = settings_.max_speed * (seconds - held), turned = std::min(unknown, any_turn);
  sample_.covariance.diagonal().head<3>().array() += unknown * unknown;
  sample_.covariance.diagonal().tail<3>().array() += turned * turned;
  sample_.covariance = (0.5 * (sample_.covariance + sample_.covariance.transpose())).eval();
  sample_.T_odom_robot = sample_.T_odom_robot * se3_exp(way);
}

}  // namespace lcmslam
