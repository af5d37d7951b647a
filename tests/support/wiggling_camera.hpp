#pragma once
// A time-of-flight camera whose range wiggles, on a drive through a corridor.

#include <cmath>
#include <functional>

#include "tests/support/analytic_scene.hpp"

namespace lcmslam::testing_scene {

constexpr double noise_per_m2 = 0.002;

using Wave = std::function<double(double)>;  // m of error at m of range

inline double wiggle(double range) {
  return 0.006 * std::sin(2 * M_PI * range / 1.9);
}

inline RgbdCalibration tof_camera() {
  RgbdCalibration calibration;
  calibration.colour = calibration.depth = {176, 144, 200, 200, 87.5, 71.5, {}};
  calibration.depth_registered = true;
  calibration.depth_noise = {0.0042, 0, 0, noise_per_m2};
  calibration.depth_max = 7.5;
  return calibration;
}

/// Walls on both sides, one at the end, floor; z up.
inline Scene corridor() {
  return {{{{0, 0, 1}, 0}, {{0, 1, 0}, 1.1}, {{0, 1, 0}, -0.9}, {{1, 0, 0}, 7}}, {}};
}

/// Depth of what stands at the true range, measured with the wave's error and noise.
inline cv::Mat measured(const Scene& scene, const RgbdCalibration& calibration,
                        const Eigen::Isometry3d& T_scene_camera, const Wave& wave, Random& random) {
  const CameraModel& camera = calibration.colour;
  cv::Mat depth(camera.height, camera.width, CV_16UC1, cv::Scalar(0));
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray = camera.ray({u, v});
      const double z = scene.hit(T_scene_camera.translation(), T_scene_camera.linear() * ray);
      const double range = z * ray.norm();
      const double seen = range + wave(range) + noise_per_m2 * range * range * random.normal();
      if (seen < calibration.depth_max)
        depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(std::lround(1000 * seen / ray.norm()));
    }
  return depth;
}

inline Eigen::Isometry3d view(double x, double y, double heading) {
  const Eigen::Isometry3d T =
      Eigen::Translation3d(x, y, 1.3) * Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(20 * M_PI / 180, Eigen::Vector3d::UnitY()) * Eigen::Isometry3d::Identity();
  return T * optical_axes();
}

}  // namespace lcmslam::testing_scene
