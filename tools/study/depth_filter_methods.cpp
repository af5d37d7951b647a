#include <cmath>
#include <opencv2/imgproc.hpp>

#include <lcmslam/imaging/depth_registration.hpp>
#include "tools/study/depth_filter_study.hpp"

namespace lcmslam {
namespace {

/// The span of valid depths in 3 x 3 pixels is more than `limit` metres.
void gradient_filter(cv::Mat& depth, double limit) {
  cv::Mat highest, lowest, filled = depth.clone();
  cv::dilate(depth, highest, cv::Mat());
  filled.setTo(65535, depth == 0);
  cv::erode(filled, lowest, cv::Mat());
  cv::Mat span;
  cv::subtract(highest, lowest, span);
  depth.setTo(0, span > 1000 * limit);
}

/// Jump edges by a fixed angle (radians) at the farther point, between its ray and the line to one of its
/// four neighbours: both ends of a steeper line go.
void fixed_angle_filter(cv::Mat& depth, const RgbdCalibration& calibration, double angle) {
  const cv::Mat before = depth.clone();
  const double pitches[2] = {1 / calibration.depth.fx, 1 / calibration.depth.fy};
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u)
      for (int side = 0; side < 2; ++side) {
        const int u2 = u + (side == 0), v2 = v + (side == 1);
        if (u2 >= depth.cols || v2 >= depth.rows) continue;
        const double a = before.at<std::uint16_t>(v, u), b = before.at<std::uint16_t>(v2, u2);
        if (a == 0 || b == 0) continue;
        const double nearer = std::min(a, b), step = std::abs(a - b);
        if (std::atan2(nearer * pitches[side], step) > angle) continue;
        depth.at<std::uint16_t>(v, u) = depth.at<std::uint16_t>(v2, u2) = 0;
      }
}

}  // namespace

std::vector<DepthFilterMethod> depth_filter_methods(const DepthFilterSettings& settings) {
  using Filter = std::function<void(cv::Mat&, const cv::Mat&)>;
  return {
      {"depth filter",
       [settings](const RgbdCalibration& calibration) -> Filter {
         return [filter = std::make_shared<DepthFilter>(calibration, settings)](
                    cv::Mat& depth, const cv::Mat& amplitude) { (*filter)(depth, amplitude); };
       }},
      {"gradient over 0.1 m, OpenCV",
       [](const RgbdCalibration&) -> Filter {
         return [](cv::Mat& depth, const cv::Mat&) { gradient_filter(depth, 0.1); };
       }},
      {"fixed angle, 170 degrees",
       [](const RgbdCalibration& calibration) -> Filter {
         return [calibration](cv::Mat& depth, const cv::Mat&) {
           fixed_angle_filter(depth, calibration, 10 * CV_PI / 180);
         };
       }},
  };
}

}  // namespace lcmslam
