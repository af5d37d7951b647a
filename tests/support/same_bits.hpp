#pragma once

#include <cstring>
#include <opencv2/core.hpp>

namespace lcmslam::testing_scene {

/// Of two whole images; NaN equals NaN.
inline bool same_bits(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && a.isContinuous() && b.isContinuous() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

}  // namespace lcmslam::testing_scene
