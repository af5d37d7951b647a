#pragma once
// The virtual camera of a map picture, and how it is placed so that the map fills the picture.

#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

struct ViewCamera {
  Eigen::Isometry3d T_camera_world = Eigen::Isometry3d::Identity();  ///< x right, y down, z forward
  bool orthographic = false;
  double scale = 1;       ///< focal length in pixels, or pixels per metre when orthographic
  double cx = 0, cy = 0;  ///< pixel on the optical axis

  /// (column, row, depth in m). In perspective only depth > 0 is in front of the camera.
  Eigen::Vector3d project(const Eigen::Vector3d& world) const;
  double pixels_per_metre(double depth) const { return orthographic ? scale : scale / depth; }
  /// Unit vector from a point towards the viewer.
  Eigen::Vector3d towards_viewer(const Eigen::Vector3d& world) const;
};

/// Rectangle of pixels that the map is fitted into.
struct ViewFrame {
  double left = 0, top = 0, width = 0, height = 0;
};

/// Horizontal rectangle of least area around the points (few outliers left aside).
struct FloorPlan {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  Eigen::Vector2d long_axis = Eigen::Vector2d::UnitX();  ///< unit
  double length = 0, width = 0;                          ///< m, length >= width
};
FloorPlan fit_floor_plan(const std::vector<Eigen::Vector3d>& points);

/// Looks down on the points, world x to the right and y up.
ViewCamera fit_top_view(const std::vector<Eigen::Vector3d>& points, const ViewFrame& frame);

/// Looks along `heading` (horizontal, unit) and down by `pitch` rad, as near as the points allow.
ViewCamera fit_perspective(const std::vector<Eigen::Vector3d>& points, const ViewFrame& frame,
                           const Eigen::Vector2d& heading, double pitch, double field_of_view);

/// Value below which the given share (0..1) of the values lies; 0 for none.
double quantile(std::vector<double> values, double share);

}  // namespace lcmslam
