#pragma once
// What of a frame the filter can use: each feature as a measurement of its kind, in the robot frame.

#include <cstdint>
#include <vector>

#include <lcmslam/fastslam/landmarks/measurement_model.hpp>
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/features/feature.hpp>

namespace lcmslam {

/// A feature that the filter can use, as a measurement in the robot frame, its covariance inflated. It
/// borrows the frame's T_robot_camera.
struct FeaturePoint {
  int feature = 0;                ///< index in FeatureFrame::features
  double range = 0;               ///< m from the sensor; 0 for a bearing
  std::int32_t landmark_id = -1;  ///< known identity; -1: the descriptor says
  Measurement measurement;

  bool is_bearing() const { return measurement.kind == MeasurementKind::bearing; }
};

/// The usable features of a frame, strongest response first: finite 3-D points in range, pixels without depth
/// (settings.use_bearings), and planar or range-bearing measurements of known identity. The order does not
/// depend on the frame's.
std::vector<FeaturePoint> usable_features(const FeatureFrame& frame, const FastSlamSettings& settings);

/// m/s, robot frame: what a standing point seems to move by, seen from a robot of velocity `twist`.
inline Eigen::Vector3d point_velocity(const Eigen::Vector3d& point, const Vector6d& twist) {
  return -twist.head<3>() - twist.tail<3>().cross(point);
}

/// The moment at which a camera saw a feature is known to `timing_sigma` (s): exposures last, rows are read
/// one after the other, depths have a clock of their own. By what a standing point seems to move meanwhile,
/// seen from a robot of velocity `twist` (m/s, rad/s, body frame), its measurement is widened.
void widen_for_motion(const Vector6d& twist, double timing_sigma, std::vector<FeaturePoint>& points);

}  // namespace lcmslam
