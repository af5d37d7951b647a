#include <lcmslam/calibration/drive.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/odometry/wheel_kinematics.hpp>

namespace lcmslam {
namespace {

constexpr Utime longest_gap = 1'000'000;  // us between the camera's poses, and between wheel readings
constexpr double least_way = 0.02, least_turn = 0.02;

double way_of(const Eigen::MatrixXd& by_wheel) {
  return by_wheel.rowwise().sum().head<2>().norm();
}

/// Without what comes late: a step from it would tell the way since then once more. Much earlier than the one
/// before is time that begins anew.
template <class Reading>
std::vector<std::pair<const Reading*, const Reading*>> neighbours_in_time(
    const std::vector<Reading>& readings) {
  std::vector<std::pair<const Reading*, const Reading*>> pairs;
  const Reading* before = nullptr;
  for (const Reading& after : readings) {
    const Utime passed = before == nullptr ? longest_gap + 1 : after.utime - before->utime;
    if (passed <= 0 && -passed <= longest_gap) continue;
    if (passed > 0 && passed <= longest_gap) pairs.emplace_back(before, &after);
    before = &after;
  }
  return pairs;
}

/// The part of a step that lies in [from, to].
WheelStep part_of(const WheelStep& step, Utime from, Utime to) {
  WheelStep part = step;
  part.from = std::max(step.from, from), part.to = std::min(step.to, to);
  const double share = static_cast<double>(part.to - part.from) / static_cast<double>(step.to - step.from);
  part.by_wheel *= share;
  part.way *= share;
  return part;
}

/// The steps that fill [from, to]; none where they have gaps or do not reach.
std::vector<WheelStep> steps_between(const std::vector<WheelStep>& steps, Utime from, Utime to) {
  auto at = std::upper_bound(steps.begin(), steps.end(), from,
                             [](Utime t, const WheelStep& step) { return t < step.to; });
  std::vector<WheelStep> found;
  Utime reached = from;
  for (; at != steps.end() && at->from < to; ++at) {
    if (at->from > reached) return {};
    found.push_back(part_of(*at, from, to));
    reached = found.back().to;
  }
  return reached == to ? found : std::vector<WheelStep>{};
}

}  // namespace

std::vector<WheelStep> wheel_steps(const std::vector<Encoders>& encoders) {
  std::vector<WheelStep> steps;
  for (const auto& [earlier, later] : neighbours_in_time(encoders)) {
    const Encoders &before = *earlier, &after = *later;
    const std::size_t n = after.wheels.size();
    if (before.wheels.size() != n) continue;
    WheelStep step{before.utime, after.utime, Eigen::MatrixXd(3, n), 0};
    for (std::size_t i = 0; i < n; ++i) {
      std::vector<Wheel> alone = after.wheels;  // as if this wheel alone had turned
      for (std::size_t other = 0; other < n; ++other)
        if (other != i) alone[other].angle = before.wheels[other].angle;
      step.by_wheel.col(static_cast<Eigen::Index>(i)) = fit_motion(before.wheels, alone).motion;
    }
    step.way = way_of(step.by_wheel);
    steps.push_back(std::move(step));
  }
  return steps;
}

std::vector<WheelStep> wheel_steps(const std::vector<MotionSample>& odometry) {
  std::vector<WheelStep> steps;
  for (const auto& [earlier, later] : neighbours_in_time(odometry)) {
    const MotionSample &before = *earlier, &after = *later;
    const Vector6d twist = se3_log(before.T_odom_robot.inverse() * after.T_odom_robot);
    WheelStep step{before.utime, after.utime, Eigen::Vector3d(twist[0], twist[1], twist[5]), 0};
    step.way = way_of(step.by_wheel);
    steps.push_back(std::move(step));
  }
  return steps;
}

std::vector<Stretch> cut_drive(const std::vector<MotionSample>& camera, const std::vector<WheelStep>& steps,
                               const StretchSettings& settings) {
  std::vector<Stretch> stretches;
  for (std::size_t begin = 0; begin < camera.size();) {
    std::size_t end = begin + 1;
    bool whole = false;
    for (; end < camera.size() && !whole; ++end) {
      if (camera[end].utime - camera[end - 1].utime > longest_gap) break;
      const Eigen::Isometry3d T = camera[begin].T_odom_robot.inverse() * camera[end].T_odom_robot;
      const double seconds = 1e-6 * static_cast<double>(camera[end].utime - camera[begin].utime);
      whole = rotation_angle(T) > settings.turn || T.translation().norm() > settings.way ||
              seconds > settings.seconds;
    }
    const std::size_t last = end - 1;
    if (!whole) {
      begin = end;
      continue;
    }
    const MotionSample &from = camera[begin], &to = camera[last];
    Stretch stretch;
    stretch.T_from_to = from.T_odom_robot.inverse() * to.T_odom_robot;
    const Matrix6d A = adjoint(stretch.T_from_to.inverse());
    stretch.covariance = to.covariance - A * from.covariance * A.transpose();
    stretch.steps = steps_between(steps, from.utime, to.utime);
    const bool moved =
        rotation_angle(stretch.T_from_to) > least_turn || stretch.T_from_to.translation().norm() > least_way;
    if (!stretch.steps.empty() && moved) stretches.push_back(std::move(stretch));
    begin = last;
  }
  return stretches;
}

}  // namespace lcmslam
