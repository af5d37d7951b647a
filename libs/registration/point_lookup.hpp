#pragma once
// What a target that keeps a cloud says about one of its points.

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/registration/target.hpp>

namespace lcmslam {

inline TargetPoint target_point(const Cloud& cloud, std::size_t i) {
  TargetPoint found;
  found.point = cloud.points[i];
  found.normal = cloud.has_normals() ? cloud.normals[i] : Eigen::Vector3f::Constant(TargetPoint::unknown);
  found.sigma = cloud.sigmas.empty() ? 0 : cloud.sigmas[i];
  if (!cloud.intensities.empty()) found.intensity = cloud.intensities[i];
  if (!cloud.gradients.empty()) found.gradient = cloud.gradients[i];
  if (!cloud.boundary.empty()) found.boundary = cloud.boundary[i] != 0;
  return found;
}

}  // namespace lcmslam
