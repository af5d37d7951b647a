#include <lcmslam/calibration/self/self_report.hpp>

#include <cmath>
#include <cstdarg>
#include <cstdio>

#include <lcmslam/calibration/covariance_text.hpp>
#include <lcmslam/calibration/self/rolling_shutter.hpp>

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
  const RollingShutter rows = rolling_shutter_of(model, result, settings);
  if (!rows.doubt.empty()) text += "  note: " + rows.doubt + "\n";
  return text;
}

std::string self_covariance_text(const BundleResult& result) {
  std::vector<std::string> names;
  std::vector<Eigen::Index> free;
  for (int i = 0; i < head::count; ++i)
    if (const auto p = static_cast<head::Parameter>(i); !result.held(p)) {
      free.push_back(i);
      names.emplace_back(name_of(p).name);
    }
  Eigen::MatrixXd covariance(free.size(), free.size());
  for (std::size_t i = 0; i < free.size(); ++i)
    for (std::size_t k = 0; k < free.size(); ++k)
      covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          result.covariance(free[i], free[k]);
  return covariance_text(
      "head", names, covariance,
      "Pixels, m, rad and s; colour_depth from where it began, in the depth camera's frame there.");
}

}  // namespace lcmslam
