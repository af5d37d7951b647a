#pragma once
// Every step-th row and column of a point image, as DepthPoints gives them of a depth image.

#include <lcmslam/imaging/thinned_depth.hpp>

namespace lcmslam::testing_scene {

inline ThinnedDepth thinned(const RegisteredDepth& whole, int step) {
  ThinnedDepth result;
  result.step = step;
  result.rows = whole.points.rows;
  result.pitch = whole.pitch;
  result.normals = estimate_normals(whole, step);
  result.points.create(result.normals.size(), CV_32FC3);
  result.sigma.create(result.normals.size(), CV_32FC1);
  for (int v = 0; v < result.points.rows; ++v)
    for (int u = 0; u < result.points.cols; ++u) {
      result.points.at<cv::Vec3f>(v, u) = whole.points.at<cv::Vec3f>(step * v, step * u);
      result.sigma.at<float>(v, u) = whole.sigma.at<float>(step * v, step * u);
    }
  return result;
}

}  // namespace lcmslam::testing_scene
