#include <lcmslam/places/view_agreement.hpp>

#include <algorithm>
#include <limits>
#include <vector>

namespace lcmslam {
namespace {

constexpr int columns = 48;
constexpr float never = std::numeric_limits<float>::infinity();

/// The nearest depth of each cell.
std::vector<float> depths_of(const Cloud& cloud, const FeatureFrame& camera, int rows, double cell) {
  std::vector<float> depths(static_cast<std::size_t>(rows) * columns, never);
  for (const Eigen::Vector3f& p : cloud.points) {
    if (!p.allFinite() || p.z() < 0.1F) continue;
    const auto z = static_cast<double>(p.z());
    const double u = (camera.fx * static_cast<double>(p.x()) / z + camera.cx) / cell;
    const double v = (camera.fy * static_cast<double>(p.y()) / z + camera.cy) / cell;
    if (!(u >= 0 && u < columns && v >= 0 && v < rows)) continue;
    float& depth = depths[static_cast<std::size_t>(v) * columns + static_cast<std::size_t>(u)];
    depth = std::min(depth, p.z());
  }
  return depths;
}

}  // namespace

ViewAgreement compare_views(const Cloud& map, const Cloud& seen, const FeatureFrame& camera) {
  ViewAgreement agreement;
  if (camera.width <= 0 || camera.height <= 0) return agreement;
  const double cell = static_cast<double>(camera.width) / columns;
  const int rows = std::max(1, static_cast<int>(camera.height / cell));
  const std::vector<float> of_map = depths_of(map, camera, rows, cell);
  const std::vector<float> of_view = depths_of(seen, camera, rows, cell);
  int agree = 0, through = 0;
  for (std::size_t i = 0; i < of_map.size(); ++i) {
    if (of_map[i] == never || of_view[i] == never) continue;
    ++agreement.compared;
    const float tolerance = 0.1F + 0.04F * of_view[i];
    agree += std::abs(of_map[i] - of_view[i]) <= tolerance;
    through += of_map[i] < of_view[i] - tolerance;
  }
  if (agreement.compared == 0) return agreement;
  agreement.agrees = static_cast<double>(agree) / agreement.compared;
  agreement.seen_through = static_cast<double>(through) / agreement.compared;
  return agreement;
}

}  // namespace lcmslam
