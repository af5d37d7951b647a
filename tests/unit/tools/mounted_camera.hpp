#pragma once
// A small camera on a robot, at no special place.

#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam::testing {

inline RgbdCalibration mounted_camera() {
  RgbdCalibration c;
  c.colour.width = c.depth.width = 64;
  c.colour.height = c.depth.height = 48;
  c.colour.fx = c.colour.fy = c.depth.fx = c.depth.fy = 60;
  c.has_mount = true;
  c.T_robot_camera = planar_pose(0.2, 0.1, 0.3) * optical_axes();
  c.T_robot_camera.translation().z() = 1.3;
  return c;
}

}  // namespace lcmslam::testing
