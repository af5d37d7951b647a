#pragma once
// One shot of the camera head as algorithms use it.

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

struct RgbdFrame {
  Utime utime = 0;        ///< of the colour image
  Utime depth_utime = 0;  ///< of the depth image
  std::int64_t seq = 0;
  std::string sensor;
  cv::Mat colour;     ///< CV_8UC3 BGR
  cv::Mat depth;      ///< CV_16UC1 millimetres along the optical axis, 0 = invalid
  cv::Mat amplitude;  ///< CV_8UC1 of the depth camera, or empty
};

}  // namespace lcmslam
