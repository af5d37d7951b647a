#pragma once
#include <lcmslam/encoders_t.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/ground_truth_t.hpp>
#include <lcmslam/messages/schema.hpp>
#include <lcmslam/odometry/encoders.hpp>
#include <lcmslam/odometry/twist_odometry.hpp>
#include <lcmslam/odometry_t.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/twist_t.hpp>

namespace lcmslam {

encoders_t to_message(const Encoders& encoders);
Encoders from_message(const encoders_t& message);

twist_t to_message(const Twist& twist);
Twist from_message(const twist_t& message);

/// Velocities are NaN (unknown) unless the caller fills them in.
odometry_t to_message(const MotionSample& sample, const std::string& source);
MotionSample from_message(const odometry_t& message);

/// Pose and covariance of a mapper; status and the rest are the caller's.
pose_estimate_t make_pose_estimate(Utime utime, const Eigen::Isometry3d& T_map_robot,
                                   const Matrix6d& covariance);

}  // namespace lcmslam
