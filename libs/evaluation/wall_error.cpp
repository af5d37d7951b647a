#include <lcmslam/evaluation/wall_error.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace lcmslam {
namespace {

struct Height {
  Utime utime;
  double value;  // m before the wall
};
/// Plane and place on it. Triangles of one plane share patches.
using PatchKey = std::array<int, 6>;
using Patches = std::map<PatchKey, std::vector<Height>>;

int rounded(float value, double unit) {
  return static_cast<int>(std::lround(static_cast<double>(value) / unit));
}

PatchKey patch_of(const Eigen::Vector3f& p, const WallTriangle& wall, double side) {
  const Eigen::Vector3f along =
      std::abs(wall.normal.z()) < 0.9f
          ? Eigen::Vector3f(Eigen::Vector3f::UnitZ().cross(wall.normal).normalized())
          : Eigen::Vector3f::UnitX();
  const Eigen::Vector3f up = wall.normal.cross(along);
  const auto cell = [&](float c) { return static_cast<int>(std::floor(static_cast<double>(c) / side)); };
  return {rounded(wall.normal.x(), 1e-3),
          rounded(wall.normal.y(), 1e-3),
          rounded(wall.normal.z(), 1e-3),
          rounded(wall.normal.dot(wall.corners[0]), 1e-3),
          cell(along.dot(p)),
          cell(up.dot(p))};
}

void add(const SeenPoint& seen, const std::vector<WallTriangle>& walls, const TriangleSurface& others,
         const WallErrorSettings& settings, Patches& patches) {
  const auto reach = static_cast<float>(settings.reach);
  const WallTriangle* nearest = nullptr;
  float least = reach;
  for (const WallTriangle& wall : walls) {
    if (seen.normal.allFinite() && static_cast<double>(seen.normal.dot(wall.normal)) < settings.min_cosine)
      continue;
    const float height = std::abs(wall.normal.dot(seen.point - wall.corners[0]));
    if (height >= least || distance(seen.point, wall.corners) > height + 1e-4f) continue;  // beside it
    least = height;
    nearest = &wall;
  }
  if (nearest == nullptr || others.distance(seen.point) < least) return;
  patches[patch_of(seen.point, *nearest, settings.patch)].push_back(
      {seen.utime, static_cast<double>(nearest->normal.dot(seen.point - nearest->corners[0]))});
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
}

double median_height(const std::vector<Height>& heights, std::size_t begin, std::size_t end) {
  std::vector<double> values;
  for (std::size_t i = begin; i < end; ++i) values.push_back(heights[i].value);
  return quantile(std::move(values), 0.5);
}

// Ends (in `heights`, sorted by time) of the visits that saw enough.
std::vector<std::array<std::size_t, 2>> visits(const std::vector<Height>& heights,
                                               const WallErrorSettings& settings) {
  std::vector<std::array<std::size_t, 2>> all;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= heights.size(); ++i) {
    const bool ends = i == heights.size() ||
                      static_cast<double>(heights[i].utime - heights[i - 1].utime) > 1e6 * settings.away;
    if (!ends) continue;
    if (i - begin >= static_cast<std::size_t>(settings.min_points)) all.push_back({begin, i});
    begin = i;
  }
  return all;
}

}  // namespace

WallError wall_error(const std::vector<SeenPoint>& points, const std::vector<WallTriangle>& walls,
                     const TriangleSurface& others, const WallErrorSettings& settings) {
  std::vector<Triangle> corners;
  corners.reserve(walls.size());
  for (const WallTriangle& wall : walls) corners.push_back(wall.corners);
  const TriangleSurface wall_surface(std::move(corners));
  const auto reach = static_cast<float>(settings.reach);
  Patches patches;
  std::size_t finite = 0, beyond = 0;
  for (const SeenPoint& seen : points) {
    if (!seen.point.allFinite()) continue;
    ++finite;
    // Whichever way it faces: near an edge normals say little.
    if (std::min(wall_surface.distance(seen.point), others.distance(seen.point)) >= reach) ++beyond;
    add(seen, walls, others, settings, patches);
  }

  std::vector<double> thicknesses, offsets;
  for (auto& [key, heights] : patches) {
    if (heights.size() < static_cast<std::size_t>(settings.min_points)) continue;
    std::stable_sort(heights.begin(), heights.end(),
                     [](const Height& a, const Height& b) { return a.utime < b.utime; });
    std::vector<double> values;
    for (const Height& h : heights) values.push_back(h.value);
    thicknesses.push_back(quantile(values, 0.975) - quantile(values, 0.025));
    const auto seen = visits(heights, settings);
    if (seen.size() < 2) continue;
    offsets.push_back(std::abs(median_height(heights, seen.back()[0], seen.back()[1]) -
                               median_height(heights, seen.front()[0], seen.front()[1])));
  }
  WallError error;
  error.points = finite;
  error.beyond = finite > 0 ? static_cast<double>(beyond) / static_cast<double>(finite)
                            : std::numeric_limits<double>::quiet_NaN();
  error.patches = static_cast<int>(thicknesses.size());
  error.thickness_median = quantile(thicknesses, 0.5);
  error.thickness_p95 = quantile(thicknesses, 0.95);
  error.revisited = static_cast<int>(offsets.size());
  error.offset_median = quantile(offsets, 0.5);
  error.offset_p95 = quantile(offsets, 0.95);
  error.offset_max = quantile(offsets, 1);
  return error;
}

}  // namespace lcmslam
