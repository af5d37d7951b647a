#pragma once
// A small room with known geometry for the sensor tests.

#include <algorithm>
#include <cmath>
#include <string>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/imaging/camera_model.hpp>
#include <lcmslam/simulation/pixel_noise.hpp>
#include <lcmslam/simulation/ray_caster.hpp>

namespace lcmslam {

/// x from -2 to `distance` (the wall ahead), y from -6 to 6, camera height 1.5 m at the origin.
inline Scene box_room(double distance, const std::string& more = "", double infrared = 0.64) {
  return read_scene(
      ConfigNode::parse("name: box\n"
                        "materials:\n"
                        "  - {name: wall, colour: [128, 128, 128], infrared: " +
                        std::to_string(infrared) +
                        "}\n"
                        "  - {name: red, colour: [220, 20, 20], infrared: 0.64}\n"
                        "  - {name: black, colour: [10, 10, 10], infrared: 0.01}\n"
                        "rooms: [{from: [-2, -6], to: [" +
                        std::to_string(distance) +
                        ", 6], height: 3, walls: wall, floor: wall, ceiling: wall}]\n"
                        "path: [0, 0, 1, 0]\nambient: 1\n" +
                        more));
}

/// A camera 1.5 m above the floor that looks along x.
inline Eigen::Isometry3d level_camera() {
  return Eigen::Translation3d(0, 0, 1.5) * optical_axes();
}

inline CameraModel pinhole_camera(int width, int height, double focal) {
  CameraModel camera;
  camera.width = width, camera.height = height;
  camera.fx = camera.fy = focal;
  camera.cx = (width - 1) / 2.0, camera.cy = (height - 1) / 2.0;
  return camera;
}

inline CameraModel tof_model() {
  return pinhole_camera(176, 144, 200);
}

struct Moments {
  double mean = 0, deviation = 0;
  int count = 0;
};

template <class Values>
Moments moments(const Values& values) {
  Moments result;
  for (const double value : values) result.mean += value, ++result.count;
  result.mean /= result.count;
  for (const double value : values) result.deviation += (value - result.mean) * (value - result.mean);
  result.deviation = std::sqrt(result.deviation / result.count);
  return result;
}

}  // namespace lcmslam
