#pragma once
// What is known of a camera head: both cameras, how they sit on each other and on the robot, and
// their noise. Stands with the sensor or the data set and is the same for every algorithm preset.

#include <cmath>
#include <string>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/imaging/camera_model.hpp>
#include <lcmslam/imaging/depth_error.hpp>

namespace lcmslam {

/// Standard deviation of a depth value in metres:
///   constant + quadratic * (z - offset)^2 + amplitude * z^2 / sqrt(a),  a = amplitude image / 255.
struct DepthNoise {
  double constant = 0.0012;   ///< m
  double quadratic = 0.0019;  ///< 1/m
  double offset = 0.4;        ///< m
  double amplitude = 0;       ///< 1/m; 0 for cameras without an amplitude image
  double sigma(double z, double relative_amplitude = 1.0) const;
};

struct RgbdCalibration {
  std::string sensor = "rgbd";
  CameraModel colour;
  CameraModel depth;              ///< equals colour when depth_registered
  bool depth_registered = false;  ///< depth pixel (u, v) lies on the same ray as colour pixel (u, v)
  Eigen::Isometry3d T_colour_depth = Eigen::Isometry3d::Identity();
  bool has_mount = false;                             ///< false: hand-held, T_robot_camera is optical_axes()
  Eigen::Isometry3d T_robot_camera = optical_axes();  ///< colour camera
  double depth_clock_offset = 0;  ///< s, added to a depth stamp gives colour's clock; whoever compares
                                  ///< or pairs the two stamps applies it (depth_time), images keep their own
  double rolling_shutter = 0;     ///< s from an image's first row to its last; 0: all rows at once
  DepthNoise depth_noise;
  DepthError depth_error;    ///< of the images as they come; decoding takes it out (decode_images)
  double depth_min = 0.3;    ///< m; nearer values are invalid
  double depth_max = 10;     ///< m
  double pixel_sigma = 1.0;  ///< standard deviation of a feature's position, pixels

  Utime depth_offset() const { return static_cast<Utime>(std::llround(depth_clock_offset * 1e6)); }  ///< us
  /// Stamp of a depth image on the colour camera's clock.
  Utime depth_time(Utime depth_utime) const { return depth_utime + depth_offset(); }

  void check() const;  ///< throws std::invalid_argument naming the wrong value
};

}  // namespace lcmslam
