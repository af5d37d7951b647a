#pragma once
// Do the mount and the depth's scale fit the motion? How the camera sees itself turn and move, by features
// with depth, carried into the robot's frame by the mount, must be how odometry says that the robot moves.
// Needs no floor in sight.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

class MountMotion {
 public:
  /// Of the colour camera.
  explicit MountMotion(const Eigen::Isometry3d& T_robot_camera) : T_robot_camera_(T_robot_camera) {}

  /// The features of the next frame. `motion(from, to)`: the robot's by odometry between two frames' stamps;
  /// nothing where it is not known.
  void add(const FeatureFrame& frame,
           const std::function<std::optional<Motion>(Utime from, Utime to)>& motion);

  /// A motion that was seen, and the robot's own by odometry: T_from_to of the camera's and of the robot's
  /// frame.
  void add(const Eigen::Isometry3d& seen, const Eigen::Isometry3d& robot);
  /// Motions that were large enough to compare, turns or ways.
  int motions() const { return motions_; }

  /// What looks wrong, and what would be right; empty: nothing does, or the robot has not turned enough.
  std::string finding() const;

 private:
  Eigen::Isometry3d T_robot_camera_;
  std::optional<FeatureFrame> last_;
  int motions_ = 0;
  std::vector<double> turns_, ways_;                // rad, between the axes and between the directions
  std::vector<double> scales_;                      // of the way seen by the camera's by odometry
  Eigen::Vector3d axis_ = Eigen::Vector3d::Zero();  // in the camera's frame, of the robot's turns to the left
};

}  // namespace lcmslam
