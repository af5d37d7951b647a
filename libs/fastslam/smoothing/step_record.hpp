#pragma once
// A step of the filter as the smoothers need it, and the particles when they go the same way once more.

#include <cstdint>
#include <vector>

#include <lcmslam/fastslam/association/association.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

struct StepRecord {
  Utime utime = 0;
  Motion odometry;                                                  ///< as motion_prior() gives it
  CalibrationJacobian calibration_jacobian;                         ///< of its right perturbation
  std::vector<FeaturePoint> measured;                               ///< as the sensor gave them
  std::vector<FeaturePoint> used;                                   ///< corrected and widened
  std::vector<LandmarkMatch> observed;                              ///< the particles were weighed by these
  std::vector<LandmarkMatch> created;                               ///< after them
  bool blind = false;                                               ///< nothing observed, nothing to be made
  std::vector<std::int32_t> forgotten;                              ///< identities whose landmark died
  Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();  ///< the estimate, as published then
  Matrix6d covariance = Matrix6d::Zero();  ///< in the world that it stands in, body frame
};

}  // namespace lcmslam
