#pragma once
// A colour camera without distortion, as common RGB-D cameras have it.

#include <lcmslam/imaging/camera_model.hpp>

namespace lcmslam {

inline CameraModel vga_camera() {
  CameraModel c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 525;
  c.cx = 319.5;
  c.cy = 239.5;
  return c;
}

}  // namespace lcmslam
