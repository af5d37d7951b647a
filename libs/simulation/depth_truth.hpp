#pragma once
// Which pixels of a simulated depth image are mixed (flying), by the scene's exact geometry.

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/imaging/camera_model.hpp>
#include <lcmslam/simulation/depth_camera.hpp>
#include <lcmslam/simulation/ray_caster.hpp>
#include <lcmslam/simulation/tof_camera.hpp>

namespace lcmslam {

/// What a measured depth is. The rays of a pixel's cone meet one or several surfaces; a surface ends where
/// neighbouring rays' depths differ by more than its slope explains (a discontinuity, no smooth slope).
enum class DepthClass : std::uint8_t {
  none,  ///< no measurement
  good,  ///< within the noise of a true surface in the cone, between the surface's nearest and farthest depth
  mixed,  ///< the cone holds several surfaces, and the depth lies off each of them by more than the noise
  off     ///< off the only surface there is: a noise outlier; counts neither as good nor as mixed
};

/// The largest error that the noise allows at depth z (m) for amplitude / 255 (1 where there is none), m.
using DepthTolerance = std::function<double(double z, double relative_amplitude)>;

/// Three sigmas of the pinned noise, plus the wiggle's amplitude (its phase is not known to a user).
DepthTolerance noise_tolerance(const TofSensor& sensor);
/// Three sigmas of the pinned noise, plus half a step of the quantised disparity.
DepthTolerance noise_tolerance(const StructuredLightSensor& sensor, double fx);

class DepthTruth {
 public:
  /// Scene and caster must outlive it. `split`: rays along each side of a pixel.
  DepthTruth(const Scene& scene, const RayCaster& caster, const CameraModel& camera, DepthTolerance tolerance,
             int split = 5);

  /// DepthClass of each pixel, CV_8UC1. `depth` CV_16UC1 mm, `amplitude` CV_8UC1 or empty, of the camera's
  /// size. Where `gap` is given: CV_32FC1, depth's distance from the nearest true surface in the cone over
  /// the tolerance (0 between a surface's nearest and farthest depth), NaN where nothing was measured.
  cv::Mat classify(const cv::Mat& depth, const cv::Mat& amplitude, const Eigen::Isometry3d& T_world_camera,
                   int threads, cv::Mat* gap = nullptr) const;

 private:
  /// Where a sub-ray ends.
  struct Hit {
    float z = 0;      ///< m; infinite where it meets nothing
    float slope = 0;  ///< tangent of the incidence angle, limited
  };
  void trace_row(int sub_row, const Eigen::Isometry3f& T_world_camera, Hit* hits) const;
  float gap_to_surfaces(const Hit* hits, float z, int& surfaces) const;

  const Scene& scene_;
  const RayCaster& caster_;
  CameraModel camera_;
  DepthTolerance tolerance_;
  int split_;
  float spacing_;  ///< rad, between neighbouring sub-rays
  cv::Mat rays_;   ///< CV_32FC2 (x/z, y/z) of all sub-rays
};

}  // namespace lcmslam
