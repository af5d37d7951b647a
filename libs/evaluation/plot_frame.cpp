#include <lcmslam/evaluation/plot_frame.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/evaluation/table.hpp>

namespace lcmslam {
namespace {

const PlotColour white = {255, 255, 255}, grid_colour = {228, 228, 228}, grey = {110, 110, 110};

/// Multiples of `step` from low to high.
template <class Function>
void for_multiples(double step, double low, double high, Function function) {
  const double first = std::ceil(low / step);
  for (double k = first; k * step <= high && k < first + 1000; ++k) function(k * step);
}

}  // namespace

std::optional<PlotBounds> bounds_of(const std::vector<PlottedPath>& paths) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  PlotBounds bounds{{infinity, infinity}, {-infinity, -infinity}};
  for (const PlottedPath& path : paths) {
    for (const Eigen::Vector2d& point : path.points) {
      if (!point.allFinite()) continue;
      bounds.low = bounds.low.cwiseMin(point);
      bounds.high = bounds.high.cwiseMax(point);
    }
  }
  if (!(bounds.low.x() <= bounds.high.x())) return std::nullopt;
  return bounds;
}

double grid_step(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= value * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

std::string axis_number(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, 6);
  return fixed_number(std::abs(value) < 1e-9 ? 0 : value, decimals);
}

PlotFrame::PlotFrame(const cv::Rect2d& box, const PlotBounds& bounds, bool equal_axes)
    : box_(box), centre_(0.5 * (bounds.low + bounds.high)) {
  const Eigen::Vector2d size = bounds.high - bounds.low;
  scale_ = Eigen::Vector2d(box.width / size.x(), box.height / size.y());
  if (equal_axes) scale_.setConstant(scale_.minCoeff());
}

cv::Point2d PlotFrame::to_pixel(const Eigen::Vector2d& p) const {
  return {box_.x + 0.5 * box_.width + scale_.x() * (p.x() - centre_.x()),
          box_.y + 0.5 * box_.height - scale_.y() * (p.y() - centre_.y())};
}

Eigen::Vector2d PlotFrame::to_plane(const cv::Point2d& pixel) const {
  return {centre_.x() + (pixel.x - box_.x - 0.5 * box_.width) / scale_.x(),
          centre_.y() - (pixel.y - box_.y - 0.5 * box_.height) / scale_.y()};
}

void PlotFrame::draw_grid(PlotSurface& surface, const Eigen::Vector2d& spacing) const {
  using Anchor = PlotSurface::Anchor;
  const Eigen::Vector2d low = to_plane({box_.x, box_.br().y}), high = to_plane({box_.br().x, box_.y});
  const double step_x = grid_step(spacing.x() / scale_.x());
  for_multiples(step_x, low.x(), high.x(), [&](double x) {
    const double u = to_pixel({x, 0}).x;
    surface.line({u, box_.y}, {u, box_.br().y}, grid_colour, 1);
    surface.text(axis_number(x, step_x), {u, box_.br().y + 18}, grey, Anchor::middle);
  });
  const double step_y = grid_step(spacing.y() / scale_.y());
  for_multiples(step_y, low.y(), high.y(), [&](double y) {
    const double v = to_pixel({0, y}).y;
    surface.line({box_.x, v}, {box_.br().x, v}, grid_colour, 1);
    surface.text(axis_number(y, step_y), {box_.x - 8, v + 5}, grey, Anchor::right);
  });
  surface.box(box_, grey);
}

void PlotFrame::draw_curve(PlotSurface& surface, const PlottedPath& path) const {
  std::vector<cv::Point2d> run;
  const auto finish = [&] {
    if (run.size() > 1) surface.polyline(run, path.colour);
    run.clear();
  };
  for (const Eigen::Vector2d& point : path.points) {
    if (point.allFinite())
      run.push_back(to_pixel(point));
    else
      finish();
  }
  finish();
}

void PlotFrame::draw_ends(PlotSurface& surface, const PlottedPath& path) const {
  const auto finite = [](const Eigen::Vector2d& p) { return p.allFinite(); };
  const auto first = std::find_if(path.points.begin(), path.points.end(), finite);
  const auto last = std::find_if(path.points.rbegin(), path.points.rend(), finite);
  if (first == path.points.end()) return;
  const cv::Point2d start = to_pixel(*first), end = to_pixel(*last);
  surface.disc(start, 6, white);
  surface.disc(start, 5, path.colour);
  surface.filled_box(cv::Rect2d(end.x - 6, end.y - 6, 12, 12), white);
  surface.filled_box(cv::Rect2d(end.x - 5, end.y - 5, 10, 10), path.colour);
}

}  // namespace lcmslam
