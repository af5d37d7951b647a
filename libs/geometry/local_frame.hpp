#pragma once
// A mapper's pose in two parts, for controllers that must not see it jump:
//
//   T_map_robot = T_map_local * T_local_robot
//
// T_local_robot goes with the mapper's own pose, step by step, as far as the robot can have moved beside its
// odometry; what is more than that (an old place recognised, a map that was bent) is news of the map and no
// motion, and goes into T_map_local, the correction. (ROS's REP 105 calls the frames odom and map; there the
// local pose is dead reckoning.)
//
//   LocalFrame frame;
//   frame.advance(T_map_robot, motion since the last call, as odometry tells it);
//   frame.T_local_robot(), frame.T_map_local();

#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

class LocalFrame {
 public:
  /// The mapper's pose now; `motion` from the last call's, with a covariance (not singular where the pose is
  /// free) of what it may err by in this step. The first call places the local frame in the map.
  void advance(const Eigen::Isometry3d& T_map_robot, const Motion& motion);
  /// The map's frame is another one from now on; the local frame goes on.
  void change_map(const Eigen::Isometry3d& T_map_robot) {
    T_map_local_ = T_map_robot * T_local_robot_.inverse();
  }

  const Eigen::Isometry3d& T_local_robot() const { return T_local_robot_; }
  const Eigen::Isometry3d& T_map_local() const { return T_map_local_; }

 private:
  Eigen::Isometry3d T_local_robot_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_map_local_ = Eigen::Isometry3d::Identity();
  bool started_ = false;
};

}  // namespace lcmslam
