#pragma once
// Odometry as consumers use it: the motion between two times, with its covariance.
//
// Odometry messages carry the absolute pose T_odom_robot and its accumulated covariance, so a lost
// message costs nothing. With right perturbations the covariance of the increment a -> b is exactly
//   Q = S_b - Ad(T_b_a) S_a Ad(T_b_a)^T.

#include <deque>
#include <optional>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// Accumulated odometry at one time.
struct MotionSample {
  Utime utime = 0;
  Eigen::Isometry3d T_odom_robot = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< of T_odom_robot, body frame
  bool visual = false;                     ///< made from the same features that mappers measure
};

/// Motion from an earlier to a later time.
struct Motion {
  Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< right perturbation, frame `to`
  bool visual = false;
};

/// Without odometry the robot may have gone anywhere that its speed allows: 0.5 m and 1 rad a second, in us;
/// at last it may be turned anyhow.
Motion unknown_motion(Utime elapsed);

class MotionBuffer {
 public:
  static constexpr Utime longest_step = 2'000'000;  ///< us

  /// Keeps this much history.
  explicit MotionBuffer(Utime span_us = 10'000'000) : span_us_(span_us) {}

  /// Appends; a sample older than the newest clears the buffer first (a log that loops or a driver
  /// that restarted). Returns false when that happened. One that comes twice is left out.
  bool add(const MotionSample& sample);

  bool covers(Utime utime) const;
  bool empty() const { return samples_.empty(); }
  Utime newest() const { return samples_.empty() ? 0 : samples_.back().utime; }

  /// Interpolated odometry; nothing when the time is outside the buffer. Up to `extrapolation` us beyond
  /// the newest sample the last velocity goes on.
  std::optional<MotionSample> at(Utime utime, Utime extrapolation = 0) const;

  /// Motion between two covered times, nothing otherwise, and nothing over a gap in the samples of more than
  /// `longest_step`: nobody knows which way the robot took meanwhile. `from` may be later than `to`: then the
  /// transform is the inverse motion, the covariance its magnitude.
  std::optional<Motion> between(Utime from, Utime to, Utime extrapolation = 0) const;

 private:
  bool has_gap(Utime from, Utime to) const;

  Utime span_us_;
  std::deque<MotionSample> samples_;
};

}  // namespace lcmslam
