#pragma once
// Settings of all layers that follow a map as it grows.

#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/map_layers/distance_field.hpp>
#include <lcmslam/map_layers/navigation_grid.hpp>
#include <lcmslam/map_layers/occupancy_settings.hpp>
#include <lcmslam/planes/plane_settings.hpp>
#include <lcmslam/planes/range_error.hpp>
#include <lcmslam/surface/surface_settings.hpp>

namespace lcmslam {

struct LiveMapSettings {
  DepthFilterSettings depth_filter;
  RangeErrorSettings range_error;
  OccupancySettings occupancy;
  DistanceSettings distance;
  NavigationSettings navigation;
  SurfaceSettings surface;
  FramePlaneSettings frame_planes;
  PlaneMapSettings planes;
  ObjectSettings objects;
  double moved_distance = 0.02;
  double moved_angle = 0.01;
  int distance_every = 3;
  int distance_rest = 300;
  int refit_every = 5;
  int surface_rest = 100;
  bool background = true;

  void describe(SettingsVisitor& s) {
    s.number("moved_distance", moved_distance, "m", {1e-4, 10},
             "of a keyframe's pose after which free space and planes are made anew");
    s.number("moved_angle", moved_angle, "rad", {1e-4, 3},
             "of a keyframe's pose after which free space and planes are made anew");
    s.number(
        "distance_every", distance_every, "", {1, 1000},
        "so many frames distances follow free and occupied space, and with each keyframe; what the newest "
        "frame shows counts at once");
    s.number("distance_rest", distance_rest, "", {0, 1'000'000},
             "so many frames after the last question for distances they no longer follow; the next question "
             "then waits until they have caught up");
    s.number(
        "refit_every", refit_every, "", {1, 1000},
        "so many frames a keyframe's part of the surface follows the graph, the one that has moved most; "
        "all do when no more frames come, and before a map is saved");
    s.number("surface_rest", surface_rest, "", {0, 1'000'000},
             "so many frames after it was last looked at the surface no longer follows the graph; who looks "
             "next waits until it has caught up");
    s.flag("background", background,
           "what is made anew is made beside the frames; without it the frames wait, and the same log gives "
           "the same maps");
    s.section("depth_filter", depth_filter, "takes out of a depth image what no surface gave");
    s.section("range_error", range_error, "what the depth camera errs by at each range, learned from planes");
    s.section("occupancy", occupancy, "free and occupied space");
    s.section("distance", distance, "distances to what is occupied");
    s.section("navigation", navigation, "where a robot can drive, seen from above");
    s.section("surface", surface, "the dense coloured surface");
    s.section("frame_planes", frame_planes, "planes of a depth image");
    s.section("planes", planes, "planes of the map");
    s.section("objects", objects, "what stands on planes");
  }
};

}  // namespace lcmslam
