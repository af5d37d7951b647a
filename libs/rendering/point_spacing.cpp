#include <lcmslam/rendering/point_spacing.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace lcmslam {
namespace {

constexpr int few = 4;

struct CellHash {
  std::size_t operator()(const Eigen::Vector3i& cell) const {
    const auto part = [&](int i, std::uint64_t factor) {
      return static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell(i))) * factor;
    };
    return part(0, 73856093U) ^ part(1, 19349663U) ^ part(2, 83492791U);  // Teschner et al. 2003
  }
};

/// Points in cubic cells.
class CellCounts {
 public:
  CellCounts(const std::vector<Eigen::Vector3f>& points, float edge) : edge_(edge) {
    counts_.reserve(points.size() / 4);
    for (const Eigen::Vector3f& point : points)
      if (point.allFinite()) ++counts_[cell(point)];
  }

  /// In the eight cells around a point's nearest corner: a window of two edges, the point near its middle.
  int around(const Eigen::Vector3f& point) const {
    const Eigen::Vector3i corner = cell(point + Eigen::Vector3f::Constant(0.5F * edge_));
    int count = 0;
    for (int i = 0; i < 8; ++i) {
      const auto found = counts_.find(corner - Eigen::Vector3i(i & 1, i >> 1 & 1, i >> 2 & 1));
      if (found != counts_.end()) count += found->second;
    }
    return count;
  }

 private:
  Eigen::Vector3i cell(const Eigen::Vector3f& point) const {
    return (point / edge_).array().floor().cast<int>();
  }

  float edge_;
  std::unordered_map<Eigen::Vector3i, int, CellHash> counts_;
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
