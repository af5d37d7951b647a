// What a depth camera errs by at each range, learned from a corridor that it drives through.

#include <lcmslam/planes/range_error.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/support/analytic_scene.hpp"

namespace lcmslam {
namespace {

constexpr double degree = 0.0174533; const double noise_per_m2 = getenv("NOISE") ? atof(getenv("NOISE")) : 0.002;

using Wave = std::function<double(double)>;  // m of error at m of range

double wiggle(double range) {
  return 0.006 * std::sin(2 * M_PI * range / 1.9);
}

RgbdCalibration tof_camera() {
  RgbdCalibration calibration;
  calibration.colour = {176, 144, 200, 200, 87.5, 71.5, {}};
  calibration.depth_registered = true;
  calibration.depth_noise = {0.0042, 0, 0, noise_per_m2};
  calibration.depth_max = 7.5;
  return calibration;
}

/// Walls on both sides, one at the end, floor; z up.
testing_scene::Scene corridor() {
  return {{{{0, 0, 1}, 0}, {{0, 1, 0}, 1.1}, {{0, 1, 0}, -0.9}, {{1, 0, 0}, 7}}, {}};
}

/// Depth of what stands at the true range, measured with the wave's error and noise.
cv::Mat measured(const testing_scene::Scene& scene, const RgbdCalibration& calibration,
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

Eigen::Isometry3d view(double x, double y, double heading) {
  const Eigen::Isometry3d T =
      Eigen::Translation3d(x, y, 1.3) * Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(20 * degree, Eigen::Vector3d::UnitY()) * Eigen::Isometry3d::Identity();
  return T * optical_axes();
}

/// Ten seconds through the corridor.
RangeError after_a_drive(const Wave& wave, const RgbdCalibration& calibration = tof_camera(),
                         const RangeErrorSettings& settings = {}, std::uint64_t seed = 1) {
  Random random(seed);
  RangeError error(calibration, settings);
  for (int i = 0; i < 25; ++i)
    error.learn(measured(corridor(), calibration,
                         view(0.15 * i, 0.2 * std::sin(0.3 * i), 0.4 * std::sin(0.5 * i)), wave, random),
                400'000 * i);
  return error;
}

double rms_left(const RangeError& error, const Wave& wave) {
  double sum = 0;
  int count = 0;
  for (double range = 1.5; range < 5; range += 0.05, ++count)
    sum += std::pow(error.at(range) - wave(range), 2);
  return std::sqrt(sum / count);
}

TEST(RangeError, AWiggleIsLearnedFromWallsAndFloor) {
  const RangeError error = after_a_drive(wiggle);
  for (double range = 1; range < 6; range += 0.25)
    std::printf("%.2f true %.4f learned %.4f sigma %.4f\n", range, wiggle(range), error.at(range),
                error.sigma(range));
  EXPECT_LT(rms_left(error, wiggle), 0.001);  // of 0.0042
}

}  // namespace
}  // namespace lcmslam
