#include <lcmslam/calibration/self/rolling_shutter.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace lcmslam {
namespace {

struct Rows {
  double seconds, sigma;
  bool observed;
};

Rows rows_of(head::Parameter image, const HeadModel& model, const BundleResult& result,
             const BundleSettings& settings) {
  return {model.values[image], result.sigmas[image], is_observed(result, image, settings)};
}

bool agree(const Rows& a, const Rows& b) {
  constexpr double kernel = 3;  // standard deviations
  return std::abs(a.seconds - b.seconds) < kernel * std::hypot(a.sigma, b.sigma);
}

double together(const Rows& a, const Rows& b) {
  if (!a.observed || !b.observed) return a.observed ? a.seconds : b.seconds;
  const double of_a = 1 / (a.sigma * a.sigma), of_b = 1 / (b.sigma * b.sigma);
  return (of_a * a.seconds + of_b * b.seconds) / (of_a + of_b);
}

std::string contradiction(const Rows& colour, const Rows& depth, double start) {
  char text[240];
  std::snprintf(text, sizeof text,
                "rolling_shutter stays %.1f ms: rows take %.1f +- %.1f ms in colour and %.1f +- %.1f ms in "
                "depth, and a calibration has one number for both",
                1e3 * start, 1e3 * colour.seconds, 1e3 * colour.sigma, 1e3 * depth.seconds,
                1e3 * depth.sigma);
  return text;
}

}  // namespace

RollingShutter rolling_shutter_of(const HeadModel& model, const BundleResult& result,
                                  const BundleSettings& settings) {
  constexpr double longest = 0.1;  // s, that a calibration may say
  const Rows colour = rows_of(head::colour_rows, model, result, settings),
             depth = rows_of(head::depth_rows, model, result, settings);
  const double start = model.start.rolling_shutter;
  if (!colour.observed && !depth.observed) return {start, ""};
  if (!agree(colour, depth)) return {start, contradiction(colour, depth, start)};
  return {std::clamp(together(colour, depth), 0.0, longest), ""};
}

}  // namespace lcmslam
