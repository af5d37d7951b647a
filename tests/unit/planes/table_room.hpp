#pragma once
// A floor, two walls and a table with two things on it, looked at from several places.

#include <lcmslam/planes/plane_map.hpp>
#include "tests/support/analytic_scene.hpp"

namespace lcmslam::testing {

constexpr double table_height = 0.75;

/// z up, floor at 0; walls at x = 3 and y = 2.
inline testing_scene::Scene table_room() {
  using Box = Eigen::AlignedBox3d;
  using Point = Eigen::Vector3d;
  return {{{{0, 0, 1}, 0}, {{1, 0, 0}, 3}, {{0, 1, 0}, 2}},
          {Box(Point(1.2, -0.5, table_height - 0.04), Point(2.0, 0.7, table_height)),
           Box(Point(1.5, -0.2, table_height), Point(1.62, 0.0, table_height + 0.2)),
           Box(Point(1.4, 0.3, table_height), Point(1.5, 0.38, table_height + 0.12))}};
}

inline RgbdCalibration room_camera() {
  RgbdCalibration calibration;
  calibration.colour = {320, 240, 262, 262, 159.5, 119.5, {}};
  calibration.depth_registered = true;
  calibration.depth_noise = {0.0012, 0.0012, 0.4, 0};
  return calibration;
}

/// A camera that looks along a heading and down by 25 degrees.
inline Eigen::Isometry3d room_view(double x, double y, double heading) {
  Eigen::Isometry3d T = Eigen::Translation3d(x, y, 1.4) *
                        Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
                        Eigen::AngleAxisd(0.44, Eigen::Vector3d::UnitY()) * Eigen::Isometry3d::Identity();
  return T * optical_axes();
}

struct RoomLook {
  Eigen::Isometry3d T_map_depth;
  cv::Mat depth;
};

/// With noise; the same for every caller.
inline const std::vector<RoomLook>& room_looks() {
  static const std::vector<RoomLook> looks = [] {
    std::vector<RoomLook> made;
    Random random(11);
    const double places[][3] = {
        {0, 0, 0}, {0.1, -0.5, 0.3}, {0.3, 0.9, -0.2}, {0.2, 0.3, 0.8}, {2.8, 0.1, M_PI}};
    for (const auto& [x, y, heading] : places) {
      const RgbdCalibration camera = room_camera();
      RoomLook look{room_view(x, y, heading), {}};
      look.depth =
          testing_scene::render(table_room(), camera.colour, look.T_map_depth, &camera.depth_noise, &random);
      made.push_back(look);
    }
    return made;
  }();
  return looks;
}

inline PlaneMap room_map() {
  FramePlaneFinder finder(room_camera());
  PlaneMap map;
  for (const RoomLook& look : room_looks()) map.insert(finder(look.depth), finder.cells(), look.T_map_depth);
  return map;
}

}  // namespace lcmslam::testing
