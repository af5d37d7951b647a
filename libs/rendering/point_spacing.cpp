#include <lcmslam/rendering/point_spacing.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <lcmslam/cloud/voxel_index.hpp>

namespace lcmslam {
namespace {

constexpr int few = 4;

/// Points in cubic cells.
class CellCounts {
 public:
  CellCounts(const std::vector<Eigen::Vector3f>& points, float edge) : edge_(edge) {
    for (const Eigen::Vector3f& point : points) {
      if (!voxel_exists(point, 1 / edge_)) continue;
      const auto next = static_cast<std::int32_t>(counts_.size());
      const auto slot = static_cast<std::size_t>(index_.insert(voxel_key(cell(point)), next));
      if (slot == counts_.size()) counts_.push_back(0);
      ++counts_[slot];
    }
  }

  /// In the eight cells around a point's nearest corner: a window of two edges, the point near its middle.
  int around(const Eigen::Vector3f& point) const {
    const Eigen::Vector3f middle = point + Eigen::Vector3f::Constant(0.5F * edge_);
    if (!voxel_exists(middle, 1 / edge_)) return 0;
    const Eigen::Vector3i corner = cell(middle);
    int count = 0;
    for (int i = 0; i < 8; ++i) {
      const auto slot = index_.find(voxel_key(corner - Eigen::Vector3i(i & 1, i >> 1 & 1, i >> 2 & 1)));
      if (slot != VoxelIndex::none) count += counts_[static_cast<std::size_t>(slot)];
    }
    return count;
  }

 private:
  Eigen::Vector3i cell(const Eigen::Vector3f& point) const {
    return (point / edge_).array().floor().cast<int>();
  }

  float edge_;
  VoxelIndex index_;
  std::vector<int> counts_;
};

}  // namespace

std::vector<float> point_spacing(const std::vector<Eigen::Vector3f>& points, double finest, double coarsest) {
  std::vector<float> spacing(points.size(), static_cast<float>(finest));
  std::vector<std::size_t> lonely(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) lonely[i] = i;
  for (double window = 8 * finest; !lonely.empty() && window < few * coarsest; window *= 2) {
    const CellCounts cells(points, static_cast<float>(0.5 * window));
    std::vector<std::size_t> still;
    for (const std::size_t i : lonely) {
      if (!points[i].allFinite()) continue;
      const int count = cells.around(points[i]);
      if (count < few)
        still.push_back(i);
      else
        spacing[i] =
            static_cast<float>(std::clamp(window / std::sqrt(static_cast<double>(count)), finest, coarsest));
    }
    lonely = std::move(still);
  }
  return spacing;
}

}  // namespace lcmslam
