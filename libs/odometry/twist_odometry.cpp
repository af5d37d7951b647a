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
constexpr double usual_silence = 0.1;       // s between twists, and that one is late; mappers wait for longer
constexpr double longest_doubt = 1e-6 * MotionBuffer::longest_step;  // s that are told after timeout

}  // namespace

TwistOdometry::TwistOdometry(const TwistOdometrySettings& settings) : settings_(settings) {
  check(settings_, "twist odometry");
}

std::optional<MotionSample> TwistOdometry::update(const Twist& twist) {
  if (twist_ && twist.utime == twist_->utime) return std::nullopt;
  const bool goes_on = twist_ && twist.utime > twist_->utime;
  sample_ = goes_on ? after(1e-6 * static_cast<double>(twist.utime - twist_->utime)) : MotionSample{};
  twist_ = twist;
  sample_.utime = twist.utime + std::llround(1e6 * settings_.delay);
  if (goes_on && sample_.utime <= told_) return std::nullopt;
  told_ = sample_.utime;
  return sample_;
}

std::optional<MotionSample> TwistOdometry::hold(Utime utime, Utime next) {
  const double seconds = silence(utime);
  const bool can_wait = next - utime <= static_cast<Utime>(1e6 * usual_silence);
  if (!twist_ || utime <= told_ || (can_wait && seconds <= usual_silence)) return std::nullopt;
  if (seconds > settings_.timeout + longest_doubt) return std::nullopt;
  MotionSample sample = after(seconds);
  sample.utime = told_ = utime;
  return sample;
}

std::optional<Twist> TwistOdometry::holding(Utime utime) const {
  return silence(utime) <= settings_.timeout ? twist_ : std::nullopt;
}

double TwistOdometry::silence(Utime utime) const {
  return 1e-6 * static_cast<double>(utime - sample_.utime);
}

// From where the twist that holds began.
MotionSample TwistOdometry::after(double seconds) const {
  MotionSample sample = sample_;
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
  for (int i = 0; i < steps; ++i) sample.covariance = (A * sample.covariance * A.transpose() + Q).eval();
  constexpr double any_turn = 3;  // rad
  const double unknown = settings_.max_speed * (seconds - held), turned = std::min(unknown, any_turn);
  sample.covariance.diagonal().head<3>().array() += unknown * unknown;
  sample.covariance.diagonal().tail<3>().array() += turned * turned;
  sample.covariance = (0.5 * (sample.covariance + sample.covariance.transpose())).eval();
  sample.T_odom_robot = sample.T_odom_robot * se3_exp(way);
  return sample;
}

}  // namespace lcmslam
