#include <lcmslam/calibration/self/head_parameters.hpp>

#include <algorithm>

namespace lcmslam {
namespace {

constexpr ParameterName names[head::count] = {{"fx", "pixels"},
                                              {"fy", "pixels"},
                                              {"cx", "pixels"},
                                              {"cy", "pixels"},
                                              {"k1", ""},
                                              {"k2", ""},
                                              {"p1", ""},
                                              {"p2", ""},
                                              {"k3", ""},
                                              {"colour_depth.x", "m"},
                                              {"colour_depth.y", "m"},
                                              {"colour_depth.z", "m"},
                                              {"colour_depth.roll", "rad"},
                                              {"colour_depth.pitch", "rad"},
                                              {"colour_depth.yaw", "rad"},
                                              {"depth_scale", ""},
                                              {"depth_offset", "m"},
                                              {"depth_clock_offset", "s"},
                                              {"depth_rolling_shutter", "s"},
                                              {"depth_tilt_x", "1/m"},
                                              {"depth_tilt_y", "1/m"},
                                              {"rolling_shutter", "s"}};

}  // namespace

const ParameterName& name_of(head::Parameter parameter) {
  return names[parameter];
}

HeadNumbers CalibrationPriors::sigmas(const RgbdCalibration& start) const {
  HeadNumbers s{};
  s[head::fx] = focal_length * start.colour.fx;
  s[head::fy] = focal_length * start.colour.fy;
  s[head::cx] = s[head::cy] = principal_point;
  s[head::k1] = radial;
  s[head::k2] = 2 * radial;
  s[head::p1] = s[head::p2] = tangential;
  s[head::k3] = third_radial;
  if (!start.depth_registered)
    for (int i = 0; i < 3; ++i) {
      s[static_cast<std::size_t>(head::tx + i)] = translation;
      s[static_cast<std::size_t>(head::rx + i)] = rotation;
    }
  s[head::depth_scale] = depth_scale;
  s[head::depth_offset] = depth_offset;
  s[head::depth_clock] = depth_clock;
  s[head::depth_rows] = s[head::colour_rows] = rolling_shutter;
  // Where the depth camera's direction is free, that takes most of a tilt.
  if (start.depth_registered) s[head::depth_tilt_x] = s[head::depth_tilt_y] = depth_tilt;
  return s;
}

HeadNumbers unmodelled_sigmas(const RgbdCalibration& start) {
  HeadNumbers s{};
  s[head::fx] = 5e-4 * start.colour.fx;
  s[head::fy] = 5e-4 * start.colour.fy;
  s[head::cx] = s[head::cy] = 7e-4 * start.colour.fx;
  s[head::p1] = s[head::p2] = 1e-4;
  s[head::k1] = 1e-3, s[head::k2] = s[head::k3] = 3e-3;
  for (const auto p : {head::tx, head::ty, head::tz}) s[p] = 5e-4;
  s[head::depth_offset] = 3e-4;
  for (const auto p : {head::rx, head::ry, head::rz}) s[p] = 7e-4;
  s[head::depth_scale] = 5e-4;
  s[head::depth_clock] = 6e-4;
  s[head::depth_rows] = s[head::colour_rows] = 2e-3;
  s[head::depth_tilt_x] = s[head::depth_tilt_y] = 5e-4;
  return s;
}

HeadModel::HeadModel(const RgbdCalibration& calibration) : start(calibration), values{} {
  const CameraModel& c = start.colour;
  values[head::fx] = c.fx, values[head::fy] = c.fy, values[head::cx] = c.cx, values[head::cy] = c.cy;
  for (std::size_t i = 0; i < std::min<std::size_t>(5, c.distortion.size()); ++i)
    values[head::k1 + i] = c.distortion[i];
  values[head::depth_scale] = 1;
  values[head::depth_clock] = start.depth_clock_offset;
  values[head::depth_rows] = values[head::colour_rows] = start.rolling_shutter;
}

Eigen::Isometry3d HeadModel::T_colour_depth() const {
  if (registered()) return Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(&values[head::tx]);
  T.linear() = so3_exp(Eigen::Vector3d(&values[head::rx]));
  return start.T_colour_depth * T;
}

CameraModel HeadModel::colour() const {
  CameraModel c = start.colour;
  c.fx = values[head::fx], c.fy = values[head::fy], c.cx = values[head::cx], c.cy = values[head::cy];
  const std::size_t before = c.distortion.size();
  c.distortion.resize(before == 8 ? 8 : values[head::k3] != 0 ? 5 : 4, 0.0);
  for (std::size_t i = 0; i < std::min<std::size_t>(5, c.distortion.size()); ++i)
    c.distortion[i] = values[head::k1 + i];
  return c;
}

RgbdCalibration HeadModel::calibration() const {
  RgbdCalibration c = start;
  c.colour = colour();
  c.depth = depth();
  if (!registered()) c.T_colour_depth = T_colour_depth();
  // Images were freed of the start's error before they were compared: measured again is (1 + s) r + o, both
  // in turn.
  const double scale = 1 / values[head::depth_scale], offset = -values[head::depth_offset] * scale;
  c.depth_error.offset = start.depth_error.offset + (1 + start.depth_error.scale) * offset;
  c.depth_error.scale = (1 + start.depth_error.scale) * scale - 1;
  c.depth_error.tilt_x = start.depth_error.tilt_x + scale * values[head::depth_tilt_x];
  c.depth_error.tilt_y = start.depth_error.tilt_y + scale * values[head::depth_tilt_y];
  c.depth_clock_offset = values[head::depth_clock];
  c.rolling_shutter = std::clamp(values[head::colour_rows], 0.0, 0.1);
  return c;
}

}  // namespace lcmslam
