#pragma once
// Which measured points may enter registration and map: depth cameras measure badly from far and at grazing
// incidence. (What they invent at depth edges is gone before: imaging/depth_filter.hpp.)

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/cloud/coloured_cloud.hpp>

namespace lcmslam {

struct CloudFilterSettings {
  double min_range = 0.3;      ///< m, distance from the camera
  double max_range = 6.0;      ///< m
  double max_incidence = 1.4;  ///< rad between the viewing ray and the normal
  double max_sigma = 0.15;     ///< m
};

/// Points of a cloud in its camera's frame that are finite, have a normal, and keep the limits.
ColouredCloud usable_points(const ColouredCloud& cloud, const CloudFilterSettings& settings = {});
Cloud usable_points(const Cloud& cloud, const CloudFilterSettings& settings = {});

}  // namespace lcmslam
