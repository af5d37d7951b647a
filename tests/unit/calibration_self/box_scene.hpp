#pragma once
// A room of six walls with landmarks on them, seen by a head whose every number is known: pixels and depths
// without noise.

#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

#include <lcmslam/calibration/self/head_parameters.hpp>
#include <lcmslam/calibration/self/scene_observations.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam::testing {

inline const Eigen::Vector3d room(2.6, 1.6, 2.9);  // half sides, m

/// From a place in the room to the wall.
inline double range_to_wall(const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
  double range = 1e9;
  for (int i = 0; i < 3; ++i) {
    if (along(i) == 0) continue;
    const double wall = along(i) > 0 ? room(i) : -room(i);
    range = std::min(range, (wall - from(i)) / along(i));
  }
  return range;
}

inline RgbdCalibration true_head(bool registered = false) {
  RgbdCalibration c;
  c.colour.width = 320, c.colour.height = 240;
  c.colour.fx = 260, c.colour.fy = 261, c.colour.cx = 158, c.colour.cy = 121;
  c.colour.distortion = {0.08, -0.12, 0.001, -0.0005};
  c.depth = c.colour;
  c.depth_registered = registered;
  if (!registered) {
    c.depth.distortion.clear();
    c.depth.fx = c.depth.fy = 290;
    c.T_colour_depth.translation() << -0.03, 0.005, 0.01;
    c.T_colour_depth.linear() = so3_exp({0.01, -0.02, 0.015});
  }
  c.depth_clock_offset = -0.012;
  c.rolling_shutter = 0.02;
  return c;
}

struct Shot {
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  Vector6d twist = Vector6d::Zero();
};

/// What such a head sees, row by row at its own moment.
inline SceneObservations seen_room(const RgbdCalibration& head, const std::vector<Shot>& shots,
                                   int landmarks) {
  SceneObservations scene;
  constexpr double lag = 0.018;  // s, as stamped
  const Eigen::Isometry3d T_colour_depth =
      head.depth_registered ? Eigen::Isometry3d::Identity() : head.T_colour_depth;
  for (const Shot& shot : shots) {
    ObservedKeyframe keyframe;
    keyframe.T_world_camera = shot.T_world_camera;
    keyframe.twist = shot.twist;
    keyframe.depth_lag = lag;
    keyframe.inverse_depth.create(head.depth.height, head.depth.width, CV_32FC1);
    for (int v = 0; v < head.depth.height; ++v) {
      const double t =
          lag + head.depth_clock_offset + ((v + 0.5) / head.depth.height - 0.5) * head.rolling_shutter;
      Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
      moved.linear() = so3_exp(t * shot.twist.tail<3>());
      moved.translation() = moved.linear() * (t * shot.twist.head<3>());
      const Eigen::Isometry3d T = shot.T_world_camera * moved * T_colour_depth;
      for (int u = 0; u < head.depth.width; ++u) {
        const Eigen::Vector3d ray = head.depth.ray({u, v});
        const double z = range_to_wall(T.translation(), T.linear() * ray), stretch = ray.norm();
        keyframe.inverse_depth.at<float>(v, u) =
            static_cast<float>(1 / (z + head.depth_error.at(z * stretch) / stretch) +
                               head.depth_error.tilt_x * ray.x() + head.depth_error.tilt_y * ray.y());
      }
    }
    scene.keyframes.push_back(keyframe);
  }
  Random random(5);
  while (static_cast<int>(scene.landmarks.size()) < landmarks) {
    const Eigen::Vector3d along(random.normal(), random.normal(), random.normal());
    SightedLandmark landmark;
    landmark.point = range_to_wall(Eigen::Vector3d::Zero(), along) * along;
    for (std::size_t k = 0; k < shots.size(); ++k) {
      const Vector6d& w = shots[k].twist;
      const Eigen::Vector3d p = shots[k].T_world_camera.inverse() * landmark.point;
      std::optional<Eigen::Vector2d> pixel = head.colour.project(p);
      for (int look = 0; pixel && look < 20; ++look) {  // at the moment of the row where it is seen
        const double t = ((pixel->y() + 0.5) / head.colour.height - 0.5) * head.rolling_shutter;
        pixel = head.colour.project(so3_exp(-t * w.tail<3>()) * p - t * w.head<3>());
      }
      if (pixel && head.colour.contains(*pixel))
        landmark.sightings.push_back({static_cast<int>(k), *pixel, 1});
    }
    if (landmark.sightings.size() >= 3) scene.landmarks.push_back(landmark);
  }
  return scene;
}

/// Pixels off by `pixels`, depths by the calibration's noise: pixel by pixel.
inline void add_noise(SceneObservations& scene, double pixels, const DepthNoise& depth, std::uint64_t seed) {
  Random random(seed);
  for (auto& landmark : scene.landmarks)
    for (auto& sighting : landmark.sightings)
      sighting.pixel += pixels * Eigen::Vector2d(random.normal(), random.normal());
  for (auto& keyframe : scene.keyframes)
    for (float& inverse : cv::Mat_<float>(keyframe.inverse_depth)) {
      const double z = 1 / static_cast<double>(inverse);
      inverse = static_cast<float>(1 / (z + depth.sigma(z) * random.normal()));
    }
}

/// Depths off by `sigma` m, alike over an eighth of the image.
inline void add_shared_noise(SceneObservations& scene, double sigma, std::uint64_t seed) {
  Random random(seed);
  for (ObservedKeyframe& keyframe : scene.keyframes) {
    cv::Mat_<float> coarse(8, 10);
    for (float& value : coarse) value = static_cast<float>(sigma * random.normal());
    cv::Mat noise;
    cv::resize(coarse, noise, keyframe.inverse_depth.size(), 0, 0, cv::INTER_LINEAR);
    keyframe.inverse_depth = 1 / (1 / keyframe.inverse_depth + noise);
  }
}

inline Shot shot(const Eigen::Vector3d& place, const Eigen::Vector3d& turn,
                 const Vector6d& twist = Vector6d::Zero()) {
  Shot s;
  s.T_world_camera.translation() = place;
  s.T_world_camera.linear() = so3_exp(turn);
  s.twist = twist;
  return s;
}

/// All ways and turns.
inline std::vector<Shot> rich_motion() {
  std::vector<Shot> shots;
  for (int i = 0; i < 14; ++i) {
    const double a = i;
    Vector6d twist;
    twist << 0.4 * std::sin(1.3 * a), 0.3 * std::cos(a), 0.3 * std::sin(0.7 * a), std::sin(2.1 * a),
        std::cos(1.7 * a), 0.8 * std::sin(a);
    shots.push_back(shot(
        Eigen::Vector3d(0.3 * std::sin(a), 0.25 * std::sin(1.7 * a), 0.3 * std::cos(a)),
        Eigen::Vector3d(0.3 * std::sin(0.9 * a), 0.35 * std::cos(1.1 * a), 0.4 * std::sin(1.9 * a)), twist));
  }
  return shots;
}

}  // namespace lcmslam::testing
