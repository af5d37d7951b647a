#include <lcmslam/rgbd/mount_motion.hpp>

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include <lcmslam/features/rigid_ransac.hpp>

namespace lcmslam {
namespace {

constexpr double least_turn = 2.5 * M_PI / 180;    // rad between two frames: less shows no axis
constexpr double least_way = 0.03;                 // m, likewise
constexpr double largest_turn_ratio = 1.6;         // of both turns; beyond one of them is wrong
constexpr double largest_error = 25 * M_PI / 180;  // rad; a mount is measured better than that
constexpr double least_scale = 0.6, largest_scale = 1.7;
constexpr std::size_t enough = 8;  // motions

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.dot(b) / (a.norm() * b.norm()), -1.0, 1.0));
}

/// 0 of too few to say anything.
double median_of(std::vector<double> values) {
  if (values.size() < enough) return 0;
  const auto median = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), median, values.end());
  return *median;
}

double degrees(double radians) {
  return radians * 180 / M_PI;
}

}  // namespace

void MountMotion::add(const FeatureFrame& frame,
                      const std::function<std::optional<Motion>(Utime, Utime)>& motion) {
  const std::optional<FeatureFrame> before = std::exchange(last_, frame);
  if (!before || frame.utime <= before->utime) return;
  const auto odometry = motion(before->utime, frame.utime);
  if (!odometry) return;
  const Eigen::Isometry3d& robot = odometry->T_from_to;
  if (so3_log(robot.linear()).norm() < least_turn && robot.translation().norm() < least_way) return;
  Random random(1);
  RigidRansacSettings settings;
  settings.max_iterations = 200;
  const RigidRansacResult seen =
      align_ransac(*before, frame, match(before->features, frame.features), settings, random);
  if (seen.success) add(seen.T_a_b, robot);
}

void MountMotion::add(const Eigen::Isometry3d& seen, const Eigen::Isometry3d& robot) {
  ++motions_;
  const Eigen::Isometry3d expected = T_robot_camera_.inverse() * robot * T_robot_camera_;
  const Eigen::Vector3d turn = so3_log(seen.linear()), expected_turn = so3_log(expected.linear());
  const double ratio = turn.norm() / std::max(expected_turn.norm(), 1e-9);
  const bool turns = turn.norm() > least_turn && expected_turn.norm() > least_turn;
  if (turns && std::max(ratio, 1 / ratio) < largest_turn_ratio) {
    turns_.push_back(angle_between(turn, expected_turn));
    axis_ += turn.normalized() * (so3_log(robot.linear()).z() < 0 ? -1 : 1);
  }
  // Where the robot turns much the camera's way hangs on its lever: nearly straight ways alone are compared.
  const bool straight = expected_turn.norm() < 2 * least_turn;
  const Eigen::Vector3d way = seen.translation(), expected_way = expected.translation();
  const double shorter = std::min(robot.translation().norm(), expected_way.norm());
  if (!straight || shorter < least_way || way.norm() < least_way / 10) return;
  ways_.push_back(angle_between(way, expected_way));
  scales_.push_back(way.norm() / expected_way.norm());
}

std::string MountMotion::finding() const {
  if (const double error = median_of(turns_); error > largest_error) {
    const Eigen::Vector3d axis = axis_.normalized();
    return fmt::format(
        "mount: it does not fit the motion: when the robot turns to the left the camera sees itself turn "
        "about "
        "[{:.2f}, {:.2f}, {:.2f}] of its axes (x right, y down, z forward), which the mount puts {:.0f} "
        "degrees off "
        "the robot's; is rpy in radians, and the robot's frame x forward, y left, z up?",
        axis.x(), axis.y(), axis.z(), degrees(error));
  }
  if (const double error = median_of(ways_); error > largest_error)
    return fmt::format(
        "mount: it does not fit the motion: where the robot drives straight on the camera sees itself move "
        "{:.0f} "
        "degrees beside that; is rpy in radians, and which way does the camera look?",
        degrees(error));
  const double scale = median_of(scales_);
  if (scale > 0 && (scale < least_scale || scale > largest_scale))
    return fmt::format(
        "depth: by it the camera moves {:.2g} times as far as by the robot's odometry: is the depth scale "
        "wrong, or the wheels' radius?",
        scale);
  return "";
}

}  // namespace lcmslam
