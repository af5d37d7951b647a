#pragma once
// What the colour camera saw, and where the depth camera beside it looked.

#include <opencv2/core.hpp>

#include <lcmslam/imaging/camera_model.hpp>

namespace lcmslam {

struct ColourView {
  cv::Mat image;  ///< CV_8UC3; empty where nobody needed it
  CameraModel camera;
  CameraModel depth_camera;
  Eigen::Isometry3d T_camera_depth = Eigen::Isometry3d::Identity();
};

}  // namespace lcmslam
