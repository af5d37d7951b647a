#include <lcmslam/registration/projective_target.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <lcmslam/registration/point_lookup.hpp>

namespace lcmslam {

ProjectiveTarget::ProjectiveTarget(const Cloud& cloud, const Eigen::Isometry3d& T_target_camera,
                                   const ProjectionGrid& grid, int window)
    : cloud_(cloud), T_camera_target_(T_target_camera.inverse().cast<float>()), grid_(grid), window_(window) {
  if (grid.width <= 0 || grid.height <= 0 || !(grid.fx > 0) || !(grid.fy > 0) || window < 0)
    throw std::invalid_argument(
        "projection grid: sizes and focal lengths must be positive, window not negative");
  cells_.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height), -1);
  std::vector<float> nearest(cells_.size(), std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < cloud_.size(); ++i) {
    int column, row;
    float depth;
    if (!cell_of(cloud_.points[i], column, row, depth)) continue;
    const auto cell = static_cast<std::size_t>(row * grid_.width + column);
    if (depth >= nearest[cell]) continue;
    if (cells_[cell] < 0) ++filled_;
    nearest[cell] = depth;
    cells_[cell] = static_cast<std::int32_t>(i);
  }
}

bool ProjectiveTarget::cell_of(const Eigen::Vector3f& point, int& column, int& row, float& depth) const {
  const Eigen::Vector3f p = T_camera_target_ * point;
  depth = p.z();
  if (!p.allFinite() || !(depth > 1e-3f)) return false;
  const double u = grid_.fx * static_cast<double>(p.x() / depth) + grid_.cx;
  const double v = grid_.fy * static_cast<double>(p.y() / depth) + grid_.cy;
  if (!(u > -0.5 && v > -0.5 && u < grid_.width - 0.5 && v < grid_.height - 0.5)) return false;
  column = static_cast<int>(std::lround(u));
  row = static_cast<int>(std::lround(v));
  return column < grid_.width && row < grid_.height;
}

bool ProjectiveTarget::find(const Eigen::Vector3f& point, float max_distance, TargetPoint& found) const {
  int column, row;
  float depth;
  if (!cell_of(point, column, row, depth)) return false;
  float best = max_distance * max_distance;
  std::int32_t index = -1;
  for (int r = std::max(0, row - window_); r <= std::min(grid_.height - 1, row + window_); ++r)
    for (int c = std::max(0, column - window_); c <= std::min(grid_.width - 1, column + window_); ++c) {
      const std::int32_t i = cells_[static_cast<std::size_t>(r * grid_.width + c)];
      if (i < 0) continue;
      const float d = (cloud_.points[static_cast<std::size_t>(i)] - point).squaredNorm();
      if (d > best || (d == best && index >= 0)) continue;
      best = d;
      index = i;
    }
  if (index < 0) return false;
  found = target_point(cloud_, static_cast<std::size_t>(index));
  return true;
}

}  // namespace lcmslam
