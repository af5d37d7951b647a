#pragma once
#include <lcmslam/dense_mapper/icp_mapper.hpp>
#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/runtime/node_settings.hpp>

namespace lcmslam {

/// Section `icp`.
struct IcpNodeSettings {
  IcpMapperSettings mapper;
  DepthFilterSettings depth_filter;
  std::string pose = "auto";
  double cloud_points = 12000;
  // A frame takes a third of its period: after a short stall of the machine five are soon worked off, and
  // none is missing. Where every frame takes longer, the pose comes so many frames late.
  int frame_queue = 5;
  double max_wait = 0.15;
  double extrapolation = 0.01;
  double rolling_shutter = 0.03;
  std::vector<std::string> rolling_sensors = {"tum_default", "tum_fr1", "tum_fr2", "tum_fr3", "seven_scenes"};

  void describe(SettingsVisitor& s) {
    describe_pose(s, pose);
    s.number("cloud_points", cloud_points, "", {100, 1e7},
             "pixels of a depth image that are looked at: every second, third, ... row and column");
    describe_frame_queue(s, frame_queue);
    describe_max_wait(s, max_wait);
    s.number(
        "extrapolation", extrapolation, "s", {0, 1},
        "that visual odometry may go on beyond its newest sample: a millisecond more would cost the wait for "
        "the next image");
    s.number("rolling_shutter", rolling_shutter, "s", {0, 0.1},
             "from an image's first row to its last, of the sensors in rolling_sensors (Kinects of the first "
             "kind)");
    s.texts("rolling_sensors", rolling_sensors, "names of calibrations whose cameras read row by row");
    s.section("depth_filter", depth_filter, "takes out of a depth image what no surface gave");
    mapper.describe(s);
  }
};

}  // namespace lcmslam
