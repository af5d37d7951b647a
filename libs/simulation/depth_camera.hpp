#pragma once
// The simulated structured-light depth camera of the `rgbd` head (Kinect-like): noise that grows
// with the square of the distance, quantised disparity, holes at grazing angles and depth edges.

#include <opencv2/core.hpp>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/imaging/camera_model.hpp>
#include <lcmslam/settings/settings.hpp>
#include <lcmslam/simulation/pixel_noise.hpp>
#include <lcmslam/simulation/ray_caster.hpp>
#include <lcmslam/simulation/row_poses.hpp>

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
  double disparity_sigma = 0;         ///< pixels: adds disparity_sigma z^2 / (fx baseline) to sigma
  int correlation = 1;                ///< pixels between which the noise is interpolated; 1: each its own

  /// m, at a depth z (m) with a focal length fx (pixels).
  double sigma(double z, double fx) const {
    const double spread = z - offset;
    return constant + quadratic * spread * spread + disparity_sigma * z * z / (fx * baseline);
  }

  void describe(SettingsVisitor& s) {
    s.number("minimum", minimum, "m", {0.01, 20}, "nearest depth");
    s.number("maximum", maximum, "m", {0.01, 50}, "farthest depth");
    s.number("constant", constant, "m", {0, 1}, "sigma = constant + quadratic (z - offset)^2 + disparity's");
    s.number("quadratic", quadratic, "1/m", {0, 1}, "see constant");
    s.number("offset", offset, "m", {0, 10}, "see constant");
    s.number("baseline", baseline, "m", {0.001, 1}, "between projector and camera, or between two cameras");
    s.number("disparity_step", disparity_step, "pixels", {0.001, 1}, "of the quantised disparity");
    s.number("grazing_cosine", grazing_cosine, "", {0, 1}, "surfaces seen at flatter angles return nothing");
    s.number("edge_ratio", edge_ratio, "", {0.001, 1},
             "a neighbour nearer by more than this share of the depth makes a hole");
    s.number("disparity_sigma", disparity_sigma, "pixels", {0, 5},
             "of a match: adds disparity_sigma z^2 / (fx baseline) to sigma");
    s.number("correlation", correlation, "pixels", {1, 32},
             "between which the noise is interpolated, as windows that are matched overlap; 1: each its own");
    s.require(minimum < maximum, "maximum", "must be above minimum");
  }
};

class DepthCamera {
 public:
  DepthCamera(const Scene& scene, const RayCaster& caster, const CameraModel& camera,
              const StructuredLightSensor& sensor = {});

  /// CV_16UC1, mm along the optical axis, 0 = invalid.
  cv::Mat render(const RowPoses& poses, const PixelNoise& noise, int threads) const {
    return measure(see(poses, threads), noise, threads);
  }
  /// Without noise, CV_32FC2: depth along the optical axis (m) and cosine of the incidence angle.
  cv::Mat see(const RowPoses& poses, int threads) const;
  /// What the sensor makes of that.
  cv::Mat measure(const cv::Mat& seen, const PixelNoise& noise, int threads) const;

 private:
  void trace_row(int row, const Eigen::Isometry3f& T_world_camera, cv::Mat& exact) const;
  double noise_at(const PixelNoise& noise, int column, int row) const;
  void measure_row(int row, const cv::Mat& exact, const PixelNoise& noise, cv::Mat& depth) const;

  const Scene& scene_;
  const RayCaster& caster_;
  CameraModel camera_;
  StructuredLightSensor sensor_;
  cv::Mat rays_;  ///< CV_32FC2
};

}  // namespace lcmslam
