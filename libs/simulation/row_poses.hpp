#pragma once
// Where a camera stands while it reads its rows.

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

struct RowPoses {
  Eigen::Isometry3d T_world_camera;  ///< at the middle row
  Vector6d velocity;                 ///< of the camera in its own frame, m/s and rad/s
  double readout;                    ///< s from the first row to the last; 0: all at once

  // A camera that stands still is its pose.
  RowPoses(const Eigen::Isometry3d& T, const Vector6d& v = Vector6d::Zero(), double seconds = 0)
      : T_world_camera(T), velocity(v), readout(seconds) {}

  Eigen::Isometry3d at(int row, int rows) const {
    if (!(readout > 0) || rows < 2) return T_world_camera;
    const double seconds = readout * (static_cast<double>(row) / (rows - 1) - 0.5);
    return T_world_camera * se3_exp(Vector6d(seconds * velocity));
  }
};

}  // namespace lcmslam
