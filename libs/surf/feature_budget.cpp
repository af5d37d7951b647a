#include "surf/feature_budget.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace lcmslam {
namespace {

bool stronger(const Blob& a, const Blob& b) {
  return std::make_tuple(-a.response, a.y, a.x, a.size) < std::make_tuple(-b.response, b.y, b.x, b.size);
}

std::size_t cell_of(const Blob& blob, const FeatureBudget& budget, int width, int height) {
  const int column = static_cast<int>(blob.x) * budget.columns / width;
  const int row = static_cast<int>(blob.y) * budget.rows / height;
  return static_cast<std::size_t>(std::clamp(row, 0, budget.rows - 1) * budget.columns +
                                  std::clamp(column, 0, budget.columns - 1));
}

}  // namespace

std::vector<Blob> select_blobs(std::vector<Blob> blobs, const FeatureBudget& budget, int width, int height) {
  std::sort(blobs.begin(), blobs.end(), stronger);
  const auto limit = static_cast<std::size_t>(budget.max_features);
  if (limit == 0 || blobs.size() <= limit) return blobs;

  const auto cells = static_cast<std::size_t>(budget.columns * budget.rows);
  const double quota = std::ceil(budget.cell_share * static_cast<double>(limit) / static_cast<double>(cells));
  std::vector<int> taken(cells, 0);
  std::vector<Blob> kept, left_over;
  kept.reserve(limit);
  for (const Blob& blob : blobs) {
    int& count = taken[cell_of(blob, budget, width, height)];
    if (kept.size() < limit && count < quota) {
      kept.push_back(blob);
      ++count;
    } else {
      left_over.push_back(blob);
    }
  }
  for (const Blob& blob : left_over) {
    if (kept.size() == limit) break;
    kept.push_back(blob);
  }
  std::sort(kept.begin(), kept.end(), stronger);
  return kept;
}

}  // namespace lcmslam
