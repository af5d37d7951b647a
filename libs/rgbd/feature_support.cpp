#include <lcmslam/rgbd/feature_support.hpp>

#include <algorithm>
#include <cmath>

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

// Planes have 1/z linear in the image: opposite places and the middle between them agree, however they slant.
bool straddles(const cv::Mat& depth, const Eigen::Vector2d& pixel, double own, double size,
               double largest_step) {
  for (const double reach : reaches)
    for (int k = 0; k < directions; ++k) {
      const double angle = M_PI * k / directions;
      const Eigen::Vector2d way = reach * size * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      const double there = inverse_depth(depth, pixel + way), opposite = inverse_depth(depth, pixel - way);
      if (there > 0 && opposite > 0 && std::abs(0.5 * (there + opposite) - own) > largest_step * own)
        return true;
    }
  return false;
}

}  // namespace

int leave_out_straddling(const RgbdFrame& frame, const RgbdCalibration& calibration,
                         const Eigen::Isometry3d& T_colour_depth_time, double largest_step,
                         FeatureFrame& features) {
  if (frame.depth.empty()) return 0;
  const Eigen::Isometry3d T_depth_colour = (T_colour_depth_time * calibration.T_colour_depth).inverse();
  const double scale = calibration.depth.fx / calibration.colour.fx;
  const auto straddling = [&](const Feature& feature) {
    if (feature.kind != MeasurementKind::point) return false;
    const Eigen::Vector3d point = T_depth_colour * feature.point.cast<double>();
    const auto pixel = calibration.depth.project(point);
    return pixel && straddles(frame.depth, *pixel, 1 / point.z(), scale * feature.size, largest_step);
  };
  auto& all = features.features;
  const auto kept = std::remove_if(all.begin(), all.end(), straddling);
  const auto left_out = static_cast<int>(all.end() - kept);
  all.erase(kept, all.end());
  return left_out;
}

}  // namespace lcmslam
