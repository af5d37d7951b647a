#pragma once
// How far a map's points are from true surfaces, which are triangles.

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <unordered_map>
#include <vector>

namespace lcmslam {

using Triangle = std::array<Eigen::Vector3f, 3>;  ///< corners, m

/// Distance of a point from a triangle, m (its face, edges and corners).
float distance(const Eigen::Vector3f& point, const Triangle& triangle);

/// Triangles by the cells that their bounding boxes touch.
class TriangleSurface {
 public:
  /// Throws std::invalid_argument unless the reach is positive.
  explicit TriangleSurface(std::vector<Triangle> triangles, float reach = 0.3f);

  /// m; the reach where nothing is nearer.
  float distance(const Eigen::Vector3f& point) const;

 private:
  static std::int64_t key(const Eigen::Vector3i& cell);

  std::vector<Triangle> triangles_;
  float reach_;
  std::unordered_map<std::int64_t, std::vector<std::int32_t>> cells_;  // looked up, never iterated
};

/// NaN everywhere where there is no point: an empty map is not without error.
struct SurfaceError {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  std::size_t points = 0;
  double median = unknown, p95 = unknown, mean = unknown;  ///< m
  double beyond = unknown;  ///< share of the points that are farther than the reach, counted as it
};

/// Of points brought to the surface's frame, where `distance` tells how far they are from it (m, at most the
/// reach); points that are not finite are left out.
SurfaceError surface_error(const std::vector<Eigen::Vector3f>& points,
                           const Eigen::Isometry3d& T_surface_points,
                           const std::function<float(const Eigen::Vector3f&)>& distance, float reach = 0.3f);
SurfaceError surface_error(const std::vector<Eigen::Vector3f>& points,
                           const Eigen::Isometry3d& T_surface_points, const TriangleSurface& surface,
                           float reach = 0.3f);

}  // namespace lcmslam
