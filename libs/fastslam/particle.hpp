#pragma once
// One hypothesis of the robot's path, with the map that follows from it.

#include <vector>

#include <lcmslam/fastslam/landmarks/particle_map.hpp>
#include <lcmslam/fastslam/odometry_calibration.hpp>

namespace lcmslam {

struct Particle {
  Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_world_start = Eigen::Isometry3d::Identity();  ///< its path's first pose
  double log_weight = 0;                                            ///< not normalised
  CalibrationMean calibration = CalibrationMean::Zero();            ///< of the odometry
  int lineage = 0;  ///< its ancestor when all particles were last drawn anew
  ParticleMap map;
};

/// What one particle made of a step's observations.
struct Verdict {
  std::vector<char> accepted;  ///< one for each observation
  int count = 0;               ///< of the accepted
  double distance2 = 0;        ///< squared Mahalanobis distance, summed over the accepted
};

}  // namespace lcmslam
