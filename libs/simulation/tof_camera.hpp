#pragma once
// The simulated time-of-flight camera: a phase measurement of modulated infrared light.
//
// Each pixel receives 3x3 sub-rays; sub-ray i returns the phasor a_i exp(2 pi j r_i / 7.5 m) with
// a_i = reflectivity cos(incidence) / r_i^2. Their sum gives range and amplitude, so a pixel on a
// depth edge measures something in between (mixed or flying pixel). What is farther than 7.5 m and bright
// enough is measured 7.5 m too near, as one frequency does, and grey is corrected by that range: a folded
// surface is dark.

#include <cmath>
#include <opencv2/core.hpp>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/imaging/camera_model.hpp>
#include <lcmslam/settings/settings.hpp>
#include <lcmslam/simulation/pixel_noise.hpp>
#include <lcmslam/simulation/ray_caster.hpp>

namespace lcmslam {

struct TofSensor {
  double unambiguous_range = 7.5;    ///< m, half the modulation's wavelength
  bool folds = true;                 ///< one frequency: a turn farther is measured a turn too near
  double minimum_range = 0.3;        ///< m
  double noise = 0.001;              ///< 1/m: sigma = noise r^2 / sqrt(reflectivity cos)
  double wiggle = 0.006;             ///< m, systematic error wiggle sin(2 pi r / period + phase)
  double wiggle_period = 1.9;        ///< m
  double minimum_amplitude = 0.002;  ///< 1/m^2: weaker pixels are invalid
  int sub_rays = 3;                  ///< of a pixel along each axis
  double wiggle_phase = 0;           ///< rad
  double valid_angle = M_PI / 2;     ///< rad from the optical axis: pixels farther out are invalid

  void describe(SettingsVisitor& s) {
    s.number("unambiguous_range", unambiguous_range, "m", {0.5, 65.5}, "half the modulation's wavelength");
    s.flag("folds", folds,
           "one frequency: what is farther is measured too near by unambiguous_range (false: it is invalid)");
    s.number("minimum_range", minimum_range, "m", {0, 10}, "nearest range");
    s.require(minimum_range < unambiguous_range, "minimum_range", "must be below unambiguous_range");
    s.number("noise", noise, "1/m", {0, 1}, "sigma = noise r^2 / sqrt(reflectivity cos(incidence))");
    s.number("wiggle", wiggle, "m", {0, 0.1},
             "systematic error: wiggle sin(2 pi r / wiggle_period + wiggle_phase)");
    s.number("wiggle_period", wiggle_period, "m", {0.01, 100}, "see wiggle");
    s.number("wiggle_phase", wiggle_phase, "rad", {-7, 7}, "see wiggle");
    s.number("minimum_amplitude", minimum_amplitude, "1/m^2", {0, 10}, "weaker pixels are invalid");
    s.number("sub_rays", sub_rays, "", {1, 5}, "of a pixel along each axis: mixed pixels arise from them");
    s.number("valid_angle", valid_angle, "rad", {0.01, 1.6},
             "from the optical axis: the light does not reach pixels farther out");
  }
};

struct TofImage {
  cv::Mat depth;      ///< CV_16UC1, mm along the optical axis, 0 = invalid
  cv::Mat grey;       ///< CV_8UC1, 255 x amplitude x r^2 of the range measured (as ToF cameras publish it)
  cv::Mat amplitude;  ///< CV_32FC1, 1/m^2: reflectivity cos / r^2, also where invalid
};

class TofCamera {
 public:
  TofCamera(const Scene& scene, const RayCaster& caster, const CameraModel& camera,
            const TofSensor& sensor = {});

  TofImage render(const Eigen::Isometry3d& T_world_camera, const PixelNoise& noise, int threads) const {
    return measure(see(T_world_camera, threads), noise, threads);
  }
  /// Without noise, CV_64FC2: range (m) and amplitude (1/m^2) of each pixel's phasor.
  cv::Mat see(const Eigen::Isometry3d& T_world_camera, int threads) const;
  /// What the sensor makes of that.
  TofImage measure(const cv::Mat& seen, const PixelNoise& noise, int threads) const;

 private:
  /// What one sub-ray returns.
  struct Echo {
    float range = 0;   ///< m
    float signal = 0;  ///< reflectivity cos / r^2, 1/m^2
  };
  bool is_lit(int row, int column) const;
  void trace_row(int sub_row, const Eigen::Isometry3f& T_world_camera, std::vector<Echo>& echoes) const;
  void sum_row(int row, const std::vector<Echo>* sub_rows, cv::Mat& seen) const;
  void measure_row(int row, const cv::Mat& seen, const PixelNoise& noise, TofImage& image) const;

  const Scene& scene_;
  const RayCaster& caster_;
  CameraModel camera_;
  TofSensor sensor_;
  cv::Mat sub_rays_;  ///< CV_32FC3, unit directions of all sub-rays
  cv::Mat cosine_;    ///< CV_32FC1, z of each pixel's unit ray
};

}  // namespace lcmslam
