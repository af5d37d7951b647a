#include <lcmslam/imaging/io/calibration_text.hpp>

#include <charconv>
#include <sstream>
#include <vector>

#include <lcmslam/configuration/yaml_text.hpp>

namespace lcmslam {
namespace {

/// The shortest text that reads back as the same number.
std::string digits_of(double value) {
  char digits[40];
  return {digits, std::to_chars(std::begin(digits), std::end(digits), value).ptr};
}

std::string list_of(const std::vector<double>& values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + digits_of(value);
  return text + "]";
}

std::string camera_text(const CameraModel& c) {
  std::string text = "{width: " + std::to_string(c.width) + ", height: " + std::to_string(c.height) +
                     ", fx: " + digits_of(c.fx) + ", fy: " + digits_of(c.fy) + ", cx: " + digits_of(c.cx) +
                     ", cy: " + digits_of(c.cy);
  if (!c.distortion.empty()) text += ",\n  distortion: " + list_of(c.distortion);
  return text + "}";
}

std::string transform_text(const Eigen::Isometry3d& T) {
  const Eigen::Vector3d t = T.translation();
  Eigen::Quaterniond q(T.linear());
  q.normalize();
  return "{translation: " + list_of({t.x(), t.y(), t.z()}) +
         ",\n  quaternion: " + list_of({q.w(), q.x(), q.y(), q.z()}) + "}";
}

}  // namespace

std::string calibration_text(const RgbdCalibration& c, const std::string& comment) {
  std::ostringstream text;
  std::istringstream lines(comment);
  for (std::string line; std::getline(lines, line);) text << "# " << line << "\n";
  text << "sensor: " << yaml_quoted(c.sensor) << "\ncolour: " << camera_text(c.colour) << "\n";
  if (c.depth_registered)
    text << "depth_registered: true\n";
  else
    text << "depth: " << camera_text(c.depth) << "\ncolour_depth: " << transform_text(c.T_colour_depth)
         << "\n";
  if (c.has_mount) text << "mount: " << transform_text(c.T_robot_camera) << "\n";
  if (c.depth_clock_offset != 0) text << "depth_clock_offset: " << digits_of(c.depth_clock_offset) << "\n";
  if (c.rolling_shutter != 0) text << "rolling_shutter: " << digits_of(c.rolling_shutter) << "\n";
  const DepthNoise& n = c.depth_noise;
  text << "depth_noise: {constant: " << digits_of(n.constant) << ", quadratic: " << digits_of(n.quadratic)
       << ", offset: " << digits_of(n.offset) << ", amplitude: " << digits_of(n.amplitude) << "}\n";
  const DepthError& e = c.depth_error;
  if (!e.is_zero())
    text << "depth_error: {offset: " << digits_of(e.offset) << ", scale: " << digits_of(e.scale)
         << ", wiggle: " << digits_of(e.wiggle) << ", period: " << digits_of(e.period)
         << ", phase: " << digits_of(e.phase) << ", tilt_x: " << digits_of(e.tilt_x)
         << ", tilt_y: " << digits_of(e.tilt_y) << "}\n";
  text << "depth_min: " << digits_of(c.depth_min) << "\ndepth_max: " << digits_of(c.depth_max)
       << "\npixel_sigma: " << digits_of(c.pixel_sigma) << "\n";
  return text.str();
}

}  // namespace lcmslam
