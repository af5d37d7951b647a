#pragma once
// Walls that a camera sees on its way along x, and what a live map makes of them.

#include <lcmslam/live_map/live_map.hpp>

namespace lcmslam {

/// A camera that looks along x at a wall.
inline RgbdCalibration some_camera() {
  RgbdCalibration calibration;
  calibration.colour = calibration.depth = CameraModel{160, 120, 140, 140, 79.5, 59.5, {}};
  calibration.depth_registered = true;
  return calibration;
}

inline RgbdFrame wall(double distance) {
  RgbdFrame frame;
  frame.depth = cv::Mat(120, 160, CV_16UC1, cv::Scalar(1000 * distance));
  frame.colour = cv::Mat(120, 160, CV_8UC3, cv::Scalar(50, 100, 150));
  return frame;
}

inline LiveMapSettings waiting() {
  LiveMapSettings settings;
  settings.background = false;
  settings.surface.voxel_size = 0.04;
  settings.surface.coarse_voxel_size = 0.16;
  return settings;
}

inline FramePose at(double x) {
  return {Eigen::Translation3d(x, 0, 1) * optical_axes(), Eigen::Isometry3d::Identity()};
}

inline CellState state(const LiveMap& map, double x) {
  return map.space().ask_occupied([&](const OccupancyGrid& occupied) {
    return occupied.state(Eigen::Vector3f(static_cast<float>(x), 0, 1));
  });
}

inline double mean_x(const Mesh& mesh) {
  double sum = 0;
  for (const Eigen::Vector3f& v : mesh.vertices) sum += static_cast<double>(v.x());
  return sum / static_cast<double>(mesh.vertices.size());
}

}  // namespace lcmslam
