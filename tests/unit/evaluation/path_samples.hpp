#pragma once
// Trajectories for the tests of this folder.

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam::testing {

/// A smooth motion in all six degrees of freedom, 30 Hz.
inline Trajectory curved_path(int poses, Utime start = 1'305'031'102'000'000) {
  Trajectory trajectory;
  for (int i = 0; i < poses; ++i) {
    const double s = 0.033 * i;
    StampedPose pose;
    pose.utime = start + static_cast<Utime>(i) * 33'000;
    pose.T_world_body.translation() << 2 * std::cos(0.5 * s), 1.5 * std::sin(0.7 * s), 0.3 * std::sin(s);
    pose.T_world_body.linear() = so3_exp({0.4 * std::sin(s), 0.3 * std::cos(0.8 * s), 0.5 * s - 2});
    trajectory.push_back(pose);
  }
  return trajectory;
}

inline Eigen::Isometry3d random_pose(Random& random, double metres = 5) {
  Vector6d twist;
  for (int i = 0; i < 3; ++i) twist[i] = random.uniform(-metres, metres);
  for (int i = 3; i < 6; ++i) twist[i] = random.uniform(-1.5, 1.5);
  return se3_exp(twist);
}

inline Trajectory with_noise(Trajectory trajectory, Random& random, double metres, double radians) {
  for (StampedPose& pose : trajectory) {
    Vector6d twist;
    for (int i = 0; i < 3; ++i) twist[i] = random.normal(0, metres);
    for (int i = 3; i < 6; ++i) twist[i] = random.normal(0, radians);
    pose.T_world_body = pose.T_world_body * se3_exp(twist);
  }
  return trajectory;
}

/// The same path in another world.
inline Trajectory moved(Trajectory trajectory, const Eigen::Isometry3d& T_new_old) {
  for (StampedPose& pose : trajectory) pose.T_world_body = T_new_old * pose.T_world_body;
  return trajectory;
}

}  // namespace lcmslam::testing
