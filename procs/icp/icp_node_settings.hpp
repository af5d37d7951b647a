#pragma once
#include <lcmslam/dense_mapper/dense_mapper_settings.hpp>
#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/planes/range_error.hpp>
#include <lcmslam/runtime/node_settings.hpp>

namespace lcmslam {

/// Section `icp`.
struct IcpNodeSettings {
  DenseMapperSettings mapper;
  DepthFilterSettings depth_filter;
  RangeErrorSettings range_error;
  std::string pose = "auto";
  std::string map_frame = "map";
  double cloud_points = 12000;
  double keyframe_pixels = 12000;
  // A frame takes a third of its period: after a short stall of the machine five are soon worked off, and
  // none is missing. Where every frame takes longer, the pose comes so many frames late.
  int frame_queue = 5;
  double max_wait = 0.15;
  double extrapolation = 0.01;
  double new_map_after = 30;
  double new_map_when_carried = 5;

  void describe(SettingsVisitor& s) {
    describe_pose(s, pose);
    describe_map_frame(s, map_frame);
    s.number("cloud_points", cloud_points, "", {100, 1e7},
             "pixels of a depth image that are looked at: every second, third, ... row and column");
    s.number(
        "keyframe_pixels", keyframe_pixels, "", {100, 1e7},
        "pixels of a depth image that a keyframe's cloud is made of; with keyframe_voxel the finest that "
        "the map's file can show: 307200 of VGA and 0.005 m for 5 mm");
    describe_frame_queue(s, frame_queue);
    describe_max_wait(s, max_wait);
    s.number(
        "extrapolation", extrapolation, "s", {0, 1},
        "that visual odometry may go on beyond its newest sample: a millisecond more would cost the wait for "
        "the next image");
    s.number("new_map_after", new_map_after, "s", {0, 1e6},
             "that the robot may not be found in the map after a gap without odometry; then a new map begins "
             "beside the old one; 0: never");
    s.number(
        "new_map_when_carried", new_map_when_carried, "s", {0, 1e6},
        "of usable frames that have no place in the map since the robot was carried (carried_after); then a "
        "new map begins beside the old one; 0: never");
    s.section("depth_filter", depth_filter, "takes out of a depth image what no surface gave");
    s.section("range_error", range_error, "what the depth camera errs by at each range, learned from planes");
    mapper.describe(s);
  }
};

}  // namespace lcmslam
