#pragma once
// What stands on a plane: clusters of points above it, each with an upright oriented box.

#include <vector>

#include <lcmslam/planes/plane_map.hpp>

namespace lcmslam {

struct StandingObject {
  Eigen::Isometry3d T_map_box = Eigen::Isometry3d::Identity();  ///< middle of the box; z the plane's normal
  Eigen::Vector3d size = Eigen::Vector3d::Zero();               ///< m along the box's axes, x not below y
  int points = 0;
};

/// Points of a map (m) above the patch and within its outline; the largest object first. Its sides lie along
/// the rectangle of least area around it.
std::vector<StandingObject> find_objects(const std::vector<Eigen::Vector3f>& points, const PlanePatch& patch,
                                         const ObjectSettings& settings = {});

}  // namespace lcmslam
