#pragma once
// A correspondence, as it travels through rejection, weighting and solving.

#include <limits>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

struct Pair {
  Eigen::Vector3d source = Eigen::Vector3d::Zero();  ///< m, source frame
  Eigen::Vector3d moved = Eigen::Vector3d::Zero();   ///< m, target frame: T_target_source * source
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< m, target frame
  Eigen::Vector3d moved_normal =
      Eigen::Vector3d::Zero();  ///< source normal in the target frame, NaN where unknown
  Eigen::Vector3d target_normal = Eigen::Vector3d::Zero();             ///< target frame, NaN where unknown
  double source_intensity = std::numeric_limits<double>::quiet_NaN();  ///< 0..1, NaN where unknown
  double target_intensity = std::numeric_limits<double>::quiet_NaN();
  Eigen::Vector3d target_gradient = Eigen::Vector3d::Zero();  ///< of the intensity, 1/m, target frame
  bool boundary = false;                                      ///< the target's surface ends here
  bool young = false;                                         ///< the target's surface is
  std::size_t index = 0;                                      ///< of the point in the source cloud
  double variance = 1;                                        ///< m^2, both points' noise together
  double weight = 1;                                          ///< set by weighting
  double squared_distance() const { return (moved - target).squaredNorm(); }
};

}  // namespace lcmslam
