#include <lcmslam/evaluation/surface_error.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace lcmslam {
namespace {

Eigen::Vector3i cell_of(const Eigen::Vector3f& p, float size) {
  return (p / size).array().floor().matrix().cast<int>();
}

float to_segment(const Eigen::Vector3f& p, const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const Eigen::Vector3f ab = b - a;
  const float length2 = ab.squaredNorm();
  const float t = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0f, 1.0f) : 0.0f;
  return (a + t * ab - p).norm();
}

}  // namespace

float distance(const Eigen::Vector3f& point, const Triangle& triangle) {
  const auto& [a, b, c] = triangle;
  const Eigen::Vector3f normal = (b - a).cross(c - a);
  const float edges = std::min({to_segment(point, a, b), to_segment(point, b, c), to_segment(point, c, a)});
  const float area = normal.norm();
  if (!(area > 0)) return edges;
  const auto inside = [&](const Eigen::Vector3f& from, const Eigen::Vector3f& to) {
    return normal.dot((to - from).cross(point - from)) >= 0;
  };
  if (!inside(a, b) || !inside(b, c) || !inside(c, a)) return edges;
  return std::abs(normal.dot(point - a)) / area;
}

// Cells as large as the reach: whatever is within it touches one of 27.
TriangleSurface::TriangleSurface(std::vector<Triangle> triangles, float reach)
    : triangles_(std::move(triangles)), reach_(reach) {
  if (!(reach > 0)) throw std::invalid_argument("the reach of a surface must be positive");
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    const Triangle& t = triangles_[i];
    const Eigen::Vector3i low = cell_of(t[0].cwiseMin(t[1]).cwiseMin(t[2]), reach_);
    const Eigen::Vector3i high = cell_of(t[0].cwiseMax(t[1]).cwiseMax(t[2]), reach_);
    for (int x = low.x(); x <= high.x(); ++x)
      for (int y = low.y(); y <= high.y(); ++y)
        for (int z = low.z(); z <= high.z(); ++z)
          cells_[key({x, y, z})].push_back(static_cast<std::int32_t>(i));
  }
}

std::int64_t TriangleSurface::key(const Eigen::Vector3i& cell) {
  constexpr std::int64_t side = 1 << 20, half = side / 2;
  return ((cell.x() + half) * side + (cell.y() + half)) * side + (cell.z() + half);
}

float TriangleSurface::distance(const Eigen::Vector3f& point) const {
  float nearest = reach_;
  const Eigen::Vector3i own = cell_of(point, reach_);
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const auto found = cells_.find(key(own + Eigen::Vector3i(x, y, z)));
        if (found == cells_.end()) continue;
        for (const std::int32_t i : found->second)
          nearest = std::min(nearest, lcmslam::distance(point, triangles_[static_cast<std::size_t>(i)]));
      }
  return nearest;
}

SurfaceError surface_error(const std::vector<Eigen::Vector3f>& points,
                           const Eigen::Isometry3d& T_surface_points, const TriangleSurface& surface,
                           float reach) {
  return surface_error(
      points, T_surface_points, [&](const Eigen::Vector3f& p) { return surface.distance(p); }, reach);
}

SurfaceError surface_error(const std::vector<Eigen::Vector3f>& points,
                           const Eigen::Isometry3d& T_surface_points,
                           const std::function<float(const Eigen::Vector3f&)>& distance, float reach) {
  const Eigen::Isometry3f T = T_surface_points.cast<float>();
  std::vector<float> distances;
  for (const Eigen::Vector3f& p : points)
    if (p.allFinite()) distances.push_back(distance(T * p));
  SurfaceError error;
  error.points = distances.size();
  if (distances.empty()) return error;
  std::sort(distances.begin(), distances.end());
  const auto at = [&](double share) {
    return static_cast<double>(
        distances[static_cast<std::size_t>(share * static_cast<double>(distances.size() - 1))]);
  };
  const auto n = static_cast<double>(distances.size());
  error.median = at(0.5);
  error.p95 = at(0.95);
  error.mean = std::accumulate(distances.begin(), distances.end(), 0.0) / n;
  error.beyond =
      static_cast<double>(distances.end() - std::lower_bound(distances.begin(), distances.end(), reach)) / n;
  return error;
}

}  // namespace lcmslam
