#include <lcmslam/imaging/folded_depth.hpp>

#include <stdexcept>

namespace lcmslam {

FoldedDepthFilter::FoldedDepthFilter(const RgbdCalibration& calibration) {
  if (!(calibration.depth_noise.amplitude > 0)) return;
  turn_ = static_cast<float>(1000 * calibration.depth_max);
  const CameraModel& camera = calibration.depth_registered ? calibration.colour : calibration.depth;
  stretch_.create(camera.height, camera.width, CV_32FC1);
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u)
      stretch_.at<float>(v, u) =
          static_cast<float>(camera.ray({static_cast<double>(u), static_cast<double>(v)}).norm());
}

void FoldedDepthFilter::operator()(cv::Mat& depth, const cv::Mat& amplitude) const {
  if (turn_ <= 0 || amplitude.empty()) return;
  if (depth.type() != CV_16UC1 || amplitude.type() != CV_8UC1 || depth.size() != stretch_.size() ||
      amplitude.size() != depth.size())
    throw std::invalid_argument(
        "folded depth: depth must have 16 bits, amplitude 8, and both the calibration's size");
  for (int v = 0; v < depth.rows; ++v) {
    auto* z = depth.ptr<std::uint16_t>(v);
    const auto* a = amplitude.ptr<std::uint8_t>(v);
    const auto* stretch = stretch_.ptr<float>(v);
    for (int u = 0; u < depth.cols; ++u) {
      const float range = stretch[u] * static_cast<float>(z[u]);
      const float share = range / (range + turn_);
      const float darkest = static_cast<float>(a[u]) - 0.5f;  // before it was rounded
      const bool may_be_folded = darkest <= 255 * share * share;
      z[u] = may_be_folded ? std::uint16_t{0} : z[u];
    }
  }
}

}  // namespace lcmslam
