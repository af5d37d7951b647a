#pragma once
// A coloured cloud, as keyframes and maps keep it.

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace lcmslam {

/// A coloured cloud. All vectors have the same length, but normals and sigmas may be empty.
struct ColouredCloud {
  std::vector<Eigen::Vector3f> points;   ///< m
  std::vector<cv::Vec3b> colours;        ///< BGR
  std::vector<Eigen::Vector3f> normals;  ///< unit, towards the camera; NaN where unknown
  std::vector<float> sigmas;             ///< m, of the depth z
  std::size_t size() const { return points.size(); }
};

}  // namespace lcmslam
