#pragma once
// Which measured points may enter registration and map: depth cameras measure badly from far and at grazing
// incidence. (What they invent at depth edges is gone before: imaging/depth_filter.hpp.)

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct CloudFilterSettings {
  double min_range = 0.3;
  double max_range = 6.0;
  double max_incidence = 1.4;
  double max_sigma = 0.15;
  bool normals = true;

  void describe(SettingsVisitor& s) {
    s.number("min_range", min_range, "m", {0, 1000}, "nearest distance from the camera that is used");
    s.number("max_range", max_range, "m", {0, 1000}, "farthest distance from the camera that is used");
    s.number("max_incidence", max_incidence, "rad", {0, 3.1416},
             "widest angle between the viewing ray and the normal that is used");
    s.flag("normals", normals,
           "only points with a normal; false: all, and max_incidence judges those that have one");
    s.number("max_sigma", max_sigma, "m", {0, 1000}, "largest standard deviation of a point that is used");
    s.require(min_range <= max_range, "max_range", "must not be below min_range");
  }
};

/// Points of a cloud in its camera's frame that are finite, have a normal (unless the settings ask for none),
/// and keep the limits.
ColouredCloud usable_points(const ColouredCloud& cloud, const CloudFilterSettings& settings = {});
Cloud usable_points(const Cloud& cloud, const CloudFilterSettings& settings = {});

}  // namespace lcmslam
