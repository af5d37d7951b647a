#include <lcmslam/self_calibration/self_calibration_text.hpp>

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <sstream>

#include <lcmslam/files/decimal_text.hpp>

namespace lcmslam {
namespace {

constexpr double degree = M_PI / 180;

/// Numbers read best in these units.
double shown_as(head::Parameter p, const char*& unit) {
  switch (p) {
    case head::tx:
    case head::ty:
    case head::tz:
    case head::depth_offset:
      unit = "mm";
      return 1e3;
    case head::rx:
    case head::ry:
    case head::rz:
      unit = "degrees";
      return 1 / degree;
    case head::depth_clock:
    case head::depth_rows:
    case head::colour_rows:
      unit = "ms";
      return 1e3;
    default:
      unit = name_of(p).unit;
      return 1;
  }
}

std::string line(const char* format, ...) __attribute__((format(printf, 1, 2)));
std::string line(const char* format, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

std::string number(double value) {
  std::string text;
  append_general(text, value, 8);
  return text;
}

std::string list(const double* values, std::size_t count) {
  std::string text = "[";
  for (std::size_t i = 0; i < count; ++i) text += (i > 0 ? ", " : "") + number(values[i]);
  return text + "]";
}

std::string camera(const CameraModel& c) {
  std::string text = "{width: " + std::to_string(c.width) + ", height: " + std::to_string(c.height) +
                     ", fx: " + number(c.fx) + ", fy: " + number(c.fy) + ", cx: " + number(c.cx) +
                     ", cy: " + number(c.cy);
  if (!c.distortion.empty())
    text += ",\n         distortion: " + list(c.distortion.data(), c.distortion.size());
  return text + "}";
}

std::string transform(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  const double wxyz[] = {q.w(), q.x(), q.y(), q.z()};
  return "{translation: " + list(T.translation().data(), 3) + ", quaternion: " + list(wxyz, 4) + "}";
}

}  // namespace

std::string report_text(const HeadModel& model, const BundleResult& result, const BundleSettings& settings) {
  const HeadModel start(model.start);
  std::string text =
      line("  %-22s %12s %12s %10s %9s %9s\n", "", "start", "now", "change", "sigma", "before");
  for (int i = 0; i < head::count; ++i) {
    const auto p = static_cast<head::Parameter>(i);
    if (result.held(p)) continue;
    const char* unit = "";
    const double factor = shown_as(p, unit), before = factor * start.values[static_cast<std::size_t>(i)],
                 now = factor * model.values[static_cast<std::size_t>(i)];
    text += line("  %-22s %12.5g %12.5g %+10.3g %9.2g %9.2g %s%s\n", name_of(p).name, before, now,
                 now - before, factor * result.sigmas[static_cast<std::size_t>(i)],
                 factor * result.priors[static_cast<std::size_t>(i)], unit,
                 is_observed(result, p, settings) ? "" : "  (not observed)");
  }
  for (const std::string& direction : result.unobserved_directions)
    text += "  not observed together: " + direction + "\n";
  return text;
}

std::string calibration_yaml(const HeadModel& model, const BundleResult& result, const std::string& note) {
  const RgbdCalibration c = model.calibration();
  std::string text;
  std::istringstream lines(note);
  for (std::string comment; std::getline(lines, comment);)
    text += (comment.empty() ? "#" : "# " + comment) + "\n";
  text += "sensor: " + c.sensor + "\ncolour: " + camera(c.colour) + "\n";
  if (c.depth_registered)
    text += "depth_registered: true\n";
  else
    text += "depth: " + camera(c.depth) + "\ncolour_depth: " + transform(c.T_colour_depth) + "\n";
  if (c.has_mount) text += "mount: " + transform(c.T_robot_camera) + "\n";
  text += "depth_clock_offset: " + number(c.depth_clock_offset) +
          "\nrolling_shutter: " + number(c.rolling_shutter) + "\n";
  text += "depth_noise: {constant: " + number(c.depth_noise.constant) +
          ", quadratic: " + number(c.depth_noise.quadratic) + ", offset: " + number(c.depth_noise.offset) +
          ", amplitude: " + number(c.depth_noise.amplitude) + "}\n";
  text += "depth_min: " + number(c.depth_min) + "\ndepth_max: " + number(c.depth_max) +
          "\npixel_sigma: " + number(c.pixel_sigma) + "\n";

  std::vector<int> free;
  for (int i = 0; i < head::count; ++i)
    if (!result.held(static_cast<head::Parameter>(i))) free.push_back(i);
  text +=
      "\n# How sure that is: values as they were found (colour_depth: m and rad from the start, in the depth "
      "camera's\n"
      "# frame), standard deviations, and the lower triangle of their correlations, row by row.\n"
      "covariance:\n  parameters: [";
  for (std::size_t i = 0; i < free.size(); ++i)
    text += (i > 0 ? ", " : "") + std::string(name_of(static_cast<head::Parameter>(free[i])).name);
  std::vector<double> values, sigmas;
  for (const int i : free) {
    values.push_back(model.values[static_cast<std::size_t>(i)]);
    sigmas.push_back(result.sigmas[static_cast<std::size_t>(i)]);
  }
  text += "]\n  values: " + list(values.data(), values.size()) +
          "\n  sigmas: " + list(sigmas.data(), sigmas.size()) + "\n  correlations:\n";
  for (std::size_t i = 0; i < free.size(); ++i) {
    std::vector<double> row;
    for (std::size_t k = 0; k <= i; ++k) {
      const double scale = sigmas[i] * sigmas[k];
      row.push_back(scale > 0 ? std::round(1e4 * result.covariance(free[i], free[k]) / scale) / 1e4 : 0);
    }
    text += "    - " + list(row.data(), row.size()) + "\n";
  }
  return text;
}

}  // namespace lcmslam
