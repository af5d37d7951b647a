#pragma once
// The simulated structured-light depth camera of the `rgbd` head (Kinect-like): noise that grows
// with the square of the distance, quantised disparity, holes at grazing angles and depth edges.

#include <opencv2/core.hpp>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/imaging/camera_model.hpp>
#include <lcmslam/simulation/pixel_noise.hpp>
#include <lcmslam/simulation/ray_caster.hpp>

namespace lcmslam {

struct StructuredLightSensor {
  double minimum = 0.4, maximum = 8;  ///< m
  double constant = 0.0012;           ///< m: sigma = constant + quadratic (z - offset)^2
  double quadratic = 0.0019;          ///< 1/m
  double offset = 0.4;                ///< m
  double baseline = 0.075;            ///< m, between projector and camera
  double disparity_step = 0.125;      ///< pixels
  double grazing_cosine = 0.17;       ///< surfaces seen at flatter angles (80 degrees) return nothing
  double edge_ratio = 0.03;           ///< a neighbour that differs by more than this share of z makes an edge
};

class DepthCamera {
 public:
  DepthCamera(const Scene& scene, const RayCaster& caster, const CameraModel& camera,
              const StructuredLightSensor& sensor = {});

  /// CV_16UC1, mm along the optical axis, 0 = invalid.
  cv::Mat render(const Eigen::Isometry3d& T_world_camera, const PixelNoise& noise, int threads) const;

 private:
  void trace_row(int row, const Eigen::Isometry3f& T_world_camera, cv::Mat& exact) const;
  void measure_row(int row, const cv::Mat& exact, const PixelNoise& noise, cv::Mat& depth) const;

  const Scene& scene_;
  const RayCaster& caster_;
  CameraModel camera_;
  StructuredLightSensor sensor_;
  cv::Mat rays_;  ///< CV_32FC2
};

}  // namespace lcmslam
