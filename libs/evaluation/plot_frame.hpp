#pragma once
// A rectangle of a plot with a scale for each axis, its grid and the curves in it. Internal to
// lcmslam_evaluation.

#include <optional>

#include <lcmslam/evaluation/plot_surface.hpp>
#include <lcmslam/evaluation/trajectory_plot.hpp>

namespace lcmslam {

/// The part of the plane that is shown.
struct PlotBounds {
  Eigen::Vector2d low, high;
};

/// Smallest box around all finite points; nothing when there is none.
std::optional<PlotBounds> bounds_of(const std::vector<PlottedPath>& paths);

/// 1, 2 or 5 times a power of ten, at least `value` (above 0).
double grid_step(double value);
/// With as many decimals as multiples of `step` need.
std::string axis_number(double value, double step);

class PlotFrame {
 public:
  /// Shows `bounds` in `box`, with one scale for both axes (then more of one axis is shown) or two.
  PlotFrame(const cv::Rect2d& box, const PlotBounds& bounds, bool equal_axes);

  const cv::Rect2d& box() const { return box_; }
  double pixels_per_unit() const { return scale_.x(); }  ///< of x

  cv::Point2d to_pixel(const Eigen::Vector2d& p) const;

  /// Lines about `spacing` pixels apart, numbers at them, the border.
  void draw_grid(PlotSurface& surface, const Eigen::Vector2d& spacing) const;
  /// Points that are not finite interrupt it.
  void draw_curve(PlotSurface& surface, const PlottedPath& path) const;
  /// A disc at its start, a square at its end.
  void draw_ends(PlotSurface& surface, const PlottedPath& path) const;

 private:
  Eigen::Vector2d to_plane(const cv::Point2d& pixel) const;

  cv::Rect2d box_;
  Eigen::Vector2d scale_;   // pixels per unit
  Eigen::Vector2d centre_;  // shown in the middle of the box
};

}  // namespace lcmslam
