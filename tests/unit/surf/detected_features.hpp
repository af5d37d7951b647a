#pragma once
#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/surf/surf.hpp>

namespace lcmslam::test {

struct Features {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;

  explicit Features(const cv::Mat& image, SurfSettings settings = {}) {
    Surf(settings).detectAndCompute(image, cv::noArray(), keypoints, descriptors);
  }
};

}  // namespace lcmslam::test
