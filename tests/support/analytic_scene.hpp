#pragma once
// Exact depth images of a wall and boxes, for tests: rays are cut with planes in closed form.

#include <cmath>
#include <limits>
#include <vector>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/imaging/depth_registration.hpp>

namespace lcmslam::testing_scene {

/// Plane n . p = d and axis-aligned boxes, in one frame (here the colour camera's, at the colour
/// image's time).
struct Scene {
  struct Plane {
    Eigen::Vector3d normal;
    double offset;
  };
  std::vector<Plane> planes;
  std::vector<Eigen::AlignedBox3d> boxes;

  /// Smallest s > 0 with origin + s * direction on a surface; infinity when there is none.
  double hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& plane : planes) {
      const double s = (plane.offset - plane.normal.dot(origin)) / plane.normal.dot(direction);
      if (s > 1e-9) nearest = std::min(nearest, s);
    }
    for (const auto& box : boxes) {
      double enter = 0;
      double leave = std::numeric_limits<double>::infinity();
      for (int axis = 0; axis < 3; ++axis) {
        double a = (box.min()[axis] - origin[axis]) / direction[axis];
        double b = (box.max()[axis] - origin[axis]) / direction[axis];
        if (a > b) std::swap(a, b);
        enter = std::max(enter, a);
        leave = std::min(leave, b);
      }
      if (enter < leave && enter > 0) nearest = std::min(nearest, enter);
    }
    return nearest;
  }
};

/// Depth image in mm of a camera at T_scene_camera, with Gaussian noise of its own model if asked.
inline cv::Mat render(const Scene& scene, const CameraModel& camera, const Eigen::Isometry3d& T_scene_camera,
                      const DepthNoise* noise = nullptr, Random* random = nullptr) {
  cv::Mat depth(camera.height, camera.width, CV_16UC1, cv::Scalar(0));
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray = camera.ray({u, v});  // z component 1: s is the depth
      double z = scene.hit(T_scene_camera.translation(), T_scene_camera.linear() * ray);
      if (noise) z += noise->sigma(z) * random->normal();
      if (z < 65) depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(std::lround(z * 1000));
    }
  }
  return depth;
}

/// A ToF head like the simulation's: two cameras 8 cm apart and turned by 2 degrees, colour with a
/// distorting lens.
inline RgbdCalibration tof_head() {
  RgbdCalibration calibration;
  calibration.colour = {640, 480, 554.3, 554.3, 320.5, 238.5, {-0.12, 0.03, 0.0005, -0.0003}};
  calibration.depth = {176, 144, 200.0, 200.0, 87.5, 71.5, {}};
  calibration.T_colour_depth.translation() << 0.08, 0.01, -0.005;
  calibration.T_colour_depth.linear() =
      Eigen::AngleAxisd(0.035, Eigen::Vector3d(0.3, 1, 0.2).normalized()).toRotationMatrix();
  calibration.depth_noise = {0.004, 0.001, 0, 0};
  return calibration;
}

/// One camera for both images, as of the TUM recordings.
inline RgbdCalibration registered_head() {
  RgbdCalibration calibration;
  calibration.colour = {640, 480, 517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}};
  calibration.depth = calibration.colour;
  calibration.depth_registered = true;
  return calibration;
}

inline bool is_valid(const cv::Vec3f& p) {
  return !std::isnan(p[2]);
}
inline Eigen::Vector3d to_eigen(const cv::Vec3f& p) {
  return {p[0], p[1], p[2]};
}

}  // namespace lcmslam::testing_scene
