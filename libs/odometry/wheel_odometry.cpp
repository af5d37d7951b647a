#include <lcmslam/odometry/wheel_odometry.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include <lcmslam/odometry/wheel_kinematics.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

// Messages that wait for their reader are often stamped when they are read, all at once: over less time than
// that no speed is told.
constexpr double shortest_restart = 0.05, shortest_twist = 0.005;  // s
constexpr double least_silence = 0.3;       // s, of a motor controller that starts anew
constexpr double max_turn_per_step = 0.05;  // rad: an increment that turns more is cut for its covariance

// Rows and columns x, y, heading of a 6x6 pose covariance.
Matrix6d from_planar(const Eigen::Matrix3d& planar) {
  constexpr int index[3] = {0, 1, 5};
  Matrix6d full = Matrix6d::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) full(index[i], index[j]) = planar(i, j);
  }
  return full;
}

Matrix6d in_plane(const Matrix6d& covariance) {
  const std::array<int, 3> free{0, 1, 5};
  return from_planar(covariance(free, free));
}

bool impossible(const std::vector<Wheel>& before, const std::vector<Wheel>& after, double max_way) {
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (after[i].radius * std::abs(after[i].angle - before[i].angle) > max_way) return true;
  }
  return false;
}

/// All wheels stand where counters begin, and one of them was far from there.
bool came_home(const std::vector<Wheel>& before, const std::vector<Wheel>& after) {
  constexpr double far = 0.2, home = 0.02;  // m at the rim
  const auto way = [](const Wheel& wheel) { return wheel.radius * std::abs(wheel.angle); };
  return std::any_of(before.begin(), before.end(), [&](const Wheel& w) { return way(w) > far; }) &&
         std::all_of(after.begin(), after.end(), [&](const Wheel& w) { return way(w) < home; });
}

}  // namespace

WheelOdometry::WheelOdometry(const WheelOdometrySettings& settings) : settings_(settings) {
  check(settings_, "wheel odometry");
}

Encoders WheelOdometry::corrected(const Encoders& encoders) const {
  Encoders result = encoders;
  const std::vector<double>& factors = settings_.radius_factors;
  if (!factors.empty() && factors.size() != result.wheels.size())
    throw std::invalid_argument("encoders of " + std::to_string(result.wheels.size()) +
                                " wheels, radius_factors has " + std::to_string(factors.size()) +
                                ": one for each wheel");
  for (std::size_t i = 0; i < factors.size(); ++i) result.wheels[i].radius *= factors[i];
  for (Wheel& wheel : result.wheels) wheel.x *= settings_.layout_factor, wheel.y *= settings_.layout_factor;
  return result;
}

std::optional<MotionSample> WheelOdometry::update(const Encoders& encoders) {
  return step(corrected(encoders));
}

std::optional<MotionSample> WheelOdometry::step(const Encoders& encoders) {
  check_wheels(encoders.wheels);
  const bool first = wheels_.empty() || encoders.utime < sample_.utime;
  if (first) {
    fit_motion(encoders.wheels, encoders.wheels, settings_.side_slip_weight);  // throws when singular
    sample_ = MotionSample{};
    stand_still();
    residual_ = 0;
  } else {
    if (encoders.utime == sample_.utime) return std::nullopt;
    if (encoders.wheels.size() != wheels_.size()) {
      throw std::invalid_argument("encoders of " + std::to_string(encoders.wheels.size()) +
                                  " wheels, earlier messages had " + std::to_string(wheels_.size()) +
                                  "; a base keeps its wheels");
    }
    const double duration = 1e-6 * static_cast<double>(encoders.utime - sample_.utime);
    if (encoders.sender != sender_ || (duration >= least_silence && came_home(wheels_, encoders.wheels)) ||
        impossible(wheels_, encoders.wheels,
                   settings_.max_wheel_speed * std::max(duration, shortest_restart))) {
      add_restart(encoders.utime - sample_.utime);
    } else {
      const WheelFit fit = fit_motion(wheels_, encoders.wheels, settings_.side_slip_weight);
      integrate({fit.motion.x(), fit.motion.y(), fit.motion.z(), fit.way_rolled, duration,
                 held_sideways_at(wheels_, encoders.wheels)},
                fit.covariance);
      tell_twist(fit.motion, duration);
      residual_ = fit.residual;
    }
  }
  wheels_ = encoders.wheels;
  sender_ = encoders.sender;
  sample_.utime = encoders.utime;
  return sample_;
}

void WheelOdometry::tell_twist(const Eigen::Vector3d& way, double seconds) {
  untold_way_ += way;
  untold_seconds_ += seconds;
  if (untold_seconds_ < shortest_twist) return;
  const Eigen::Vector3d twist = untold_way_ / untold_seconds_;
  twist_ = {twist.x(), twist.y(), twist.z()};
  untold_way_.setZero();
  untold_seconds_ = 0;
}

void WheelOdometry::stand_still() {
  twist_ = {};
  untold_way_.setZero();
  untold_seconds_ = 0;
}

void WheelOdometry::integrate(const PlanarIncrement& increment, const Eigen::Matrix3d& fit_covariance) {
  // The pose needs one step, whatever its length. Noise enters all along the arc: cut it, so that the
  // covariance after a lost message is the one that the messages would have given.
  const double turn = std::abs(increment.heading);
  const int steps = std::clamp(static_cast<int>(std::ceil(turn / max_turn_per_step)), 1, 1000);
  const double fraction = 1.0 / steps;
  const PlanarIncrement step{increment.x * fraction,        increment.y * fraction,
                             increment.heading * fraction,  increment.way_rolled * fraction,
                             increment.duration * fraction, increment.held_at};
  const Matrix6d Q = increment_covariance(settings_.noise, step) + fraction * from_planar(fit_covariance);
  const Matrix6d A = adjoint(se3_exp(-step.twist()));
  for (int i = 0; i < steps; ++i) sample_.covariance = (A * sample_.covariance * A.transpose() + Q).eval();
  sample_.covariance = (0.5 * (sample_.covariance + sample_.covariance.transpose())).eval();
  sample_.T_odom_robot = sample_.T_odom_robot * se3_exp(increment.twist());
}

void WheelOdometry::add_restart(Utime uncounted) {
  ++restarts_;
  const WheelNoise& noise = settings_.noise;
  PlanarIncrement slip;
  slip.way_rolled = noise.slip_distance;
  sample_.covariance += increment_covariance(noise, slip) + in_plane(unknown_motion(uncounted).covariance);
  stand_still();
  residual_ = 0;
}

}  // namespace lcmslam
