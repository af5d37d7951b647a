#pragma once
#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/messages/schema.hpp>
#include <lcmslam/pose_t.hpp>
#include <lcmslam/rigid_transform_t.hpp>

namespace lcmslam {

rigid_transform_t to_message(const Eigen::Isometry3d& transform);

/// Throws DecodeError, naming `field`, when values are not finite or the quaternion is no unit one.
Eigen::Isometry3d from_message(const rigid_transform_t& message, const std::string& field);

/// The pose of bot_core's pose_t. Throws DecodeError likewise.
Eigen::Isometry3d from_message(const pose_t& message);

/// Row-major 6x6.
void to_message(const Matrix6d& covariance, double (&values)[36]);

/// Throws DecodeError when values are not finite or a variance is negative.
Matrix6d covariance_from_message(const double (&values)[36], const std::string& field);

/// Throws DecodeError "field: value is out of low..high" unless low <= value <= high (so not for NaN).
void check_range(double value, double low, double high, const std::string& field);

/// A robot is nowhere near this far from its start: what exceeds it is garbage.
constexpr double largest_coordinate = 1e6;  // m

}  // namespace lcmslam
