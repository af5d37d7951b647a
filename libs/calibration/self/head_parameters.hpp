#pragma once
// What a camera head's calibration without a board finds, as numbers in one order.
//
//   fx fy cx cy          the colour camera's intrinsics, pixels
//   k1 k2 p1 p2 k3       its lens (Brown-Conrady; k4 to k6 stay as the start says)
//   tx ty tz rx ry rz    T_colour_depth = T_start * (R(r), t): m and rad in the depth camera's start frame
//   depth_scale, depth_offset    true range along the ray = scale * measured + offset (m)
//   depth_tilt_x, depth_tilt_y   1/m, inverse depth measured less that expected, by the ray's x and y
//   depth_clock          s, added to a depth stamp gives the colour camera's clock
//   colour_rows, depth_rows      s from an image's first row to its last

#include <array>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

namespace head {
enum Parameter : int {
  fx,
  fy,
  cx,
  cy,
  k1,
  k2,
  p1,
  p2,
  k3,
  tx,
  ty,
  tz,
  rx,
  ry,
  rz,
  depth_scale,
  depth_offset,
  depth_clock,
  depth_rows,
  depth_tilt_x,
  depth_tilt_y,
  colour_rows,
  count
};
}  // namespace head

struct ParameterName {
  const char* name;
  const char* unit;
};
const ParameterName& name_of(head::Parameter parameter);

using HeadNumbers = std::array<double, head::count>;

/// Standard deviations of what the start calibration says; 0: that is exact and stays.
struct CalibrationPriors {
  double focal_length = 0.05, aspect = 0.003, principal_point = 15;
  double radial = 0.3, tangential = 0.005, third_radial = 1;
  double translation = 0.03, rotation = 0.03;
  double depth_scale = 0.01, depth_offset = 0.003;
  double range_curve = 1;
  double depth_clock = 0.02, rolling_shutter = 0.02;
  double depth_tilt = 0.02;

  void describe(SettingsVisitor& s) {
    s.number("focal_length", focal_length, "", {0, 1}, "of the focal length, relative");
    s.number("aspect", aspect, "", {0, 1},
             "of fx / fy, relative: pixels are nearly square; 0: one focal length");
    s.number("principal_point", principal_point, "pixels", {0, 1000}, "of cx and cy");
    s.number("radial", radial, "", {0, 10}, "of k1 (k2: twice that)");
    s.number("tangential", tangential, "", {0, 1}, "of p1 and p2");
    s.number("third_radial", third_radial, "", {0, 10}, "of k3");
    s.number("translation", translation, "m", {0, 1}, "of the depth camera's place, on each axis");
    s.number("rotation", rotation, "rad", {0, 1}, "of the depth camera's direction, about each axis");
    s.number("depth_scale", depth_scale, "", {0, 1}, "of the depths' scale");
    s.number("depth_offset", depth_offset, "m", {0, 1}, "of what all depths are off by");
    s.number("range_curve", range_curve, "", {0, 10},
             "of what all ranges err by, over the range; in units of the calibration's depth noise");
    s.number("depth_clock", depth_clock, "s", {0, 1}, "of the depth stamps' offset");
    s.number("rolling_shutter", rolling_shutter, "s", {0, 0.1}, "of the time from the first row to the last");
    s.number("depth_tilt", depth_tilt, "1/m", {0, 0.2},
             "of the slope of inverse depth's error over the image, where depth is registered");
  }
  /// Of each parameter.
  HeadNumbers sigmas(const RgbdCalibration& start) const;
};

/// Standard deviations of what no residual shows, of each parameter: a velocity that is taken for exact, a
/// lens that is not quite the model's, textures on surfaces that are not quite flat. No recording makes a
/// head surer than that.
HeadNumbers unmodelled_sigmas(const RgbdCalibration& start);

/// A head whose parameters may differ from those that it began with.
struct HeadModel {
  RgbdCalibration start;
  HeadNumbers values;

  explicit HeadModel(const RgbdCalibration& calibration);
  /// Depth pixels are colour pixels: extrinsics have no meaning.
  bool registered() const { return start.depth_registered; }

  Eigen::Isometry3d T_colour_depth() const;
  CameraModel colour() const;
  CameraModel depth() const { return registered() ? colour() : start.depth; }
  /// As a calibration file holds it. Both images' rows are one number there: colour's.
  RgbdCalibration calibration() const;
};

}  // namespace lcmslam
