#include <lcmslam/rgbd/feature_support.hpp>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace lcmslam {
namespace {

constexpr double reaches[] = {0.375, 0.75};  // of a feature's size, which is a diameter
constexpr int directions = 4;                // of half a circle

// 1/z, 1/m, of the nearest pixel; 0 where there is no depth.
double inverse_depth(const cv::Mat& depth, const Eigen::Vector2d& pixel) {
  const auto column = static_cast<int>(std::lround(pixel.x())),
             row = static_cast<int>(std::lround(pixel.y()));
  if (column < 0 || row < 0 || column >= depth.cols || row >= depth.rows) return 0;
  const int millimetres = depth.at<std::uint16_t>(row, column);
  return millimetres > 0 ? 1e3 / millimetres : 0;
}

// Of 1/z, ratio. Planes have it linear in the image: opposite places and the middle between them agree,
// however they slant.
double step_around(const cv::Mat& depth, const Eigen::Vector2d& pixel, double own, double size) {
  double step = 0;
  for (const double reach : reaches)
    for (int k = 0; k < directions; ++k) {
      const double angle = M_PI * k / directions;
      const Eigen::Vector2d way = reach * size * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      const double there = inverse_depth(depth, pixel + way), opposite = inverse_depth(depth, pixel - way);
      if (there > 0 && opposite > 0) step = std::max(step, std::abs(0.5 * (there + opposite) / own - 1));
    }
  return step;
}

// One for each feature; 0 where nothing is known.
std::vector<double> steps_around(const RgbdFrame& frame, const RgbdCalibration& calibration,
                                 const Eigen::Isometry3d& T_depth_colour,
                                 const std::vector<Feature>& features) {
  const double scale = calibration.depth.fx / calibration.colour.fx;
  std::vector<double> steps(features.size(), 0);
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (features[i].kind != MeasurementKind::point) continue;
    const Eigen::Vector3d point = T_depth_colour * features[i].point.cast<double>();
    const auto pixel = calibration.depth.project(point);
    if (pixel)
      steps[i] =
          step_around(frame.depth, *pixel, 1 / point.z(), scale * static_cast<double>(features[i].size));
  }
  return steps;
}

}  // namespace

int leave_out_straddling(const RgbdFrame& frame, const RgbdCalibration& calibration,
                         const Eigen::Isometry3d& T_colour_depth_time, const FeatureSupportSettings& settings,
                         FeatureFrame& features) {
  auto& all = features.features;
  const auto least = static_cast<std::size_t>(settings.least_features);
  if (frame.depth.empty() || all.size() <= least) return 0;
  const Eigen::Isometry3d T_depth_colour = (T_colour_depth_time * calibration.T_colour_depth).inverse();
  const std::vector<double> steps = steps_around(frame, calibration, T_depth_colour, all);
  double limit = settings.largest_depth_step;
  if (least > 0) {  // so many stay
    std::vector<double> sorted = steps;
    const auto spared = sorted.begin() + static_cast<std::ptrdiff_t>(least) - 1;
    std::nth_element(sorted.begin(), spared, sorted.end());
    limit = std::max(limit, *spared);
  }
  std::vector<Feature> kept;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (steps[i] <= limit) kept.push_back(all[i]);
  const auto left_out = static_cast<int>(all.size() - kept.size());
  all = std::move(kept);
  return left_out;
}

}  // namespace lcmslam
