#include <lcmslam/surf/feature_budget.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace lcmslam {
namespace {

bool stronger(const Blob& a, const Blob& b) {
  if (a.response != b.response) return a.response > b.response;
  return std::tie(a.y, a.x, a.size) < std::tie(b.y, b.x, b.size);
}

std::size_t cell_of(const Blob& blob, const FeatureBudget& budget, int width, int height) {
  const int column = static_cast<int>(blob.x) * budget.columns / width;
  const int row = static_cast<int>(blob.y) * budget.rows / height;
  return static_cast<std::size_t>(std::clamp(row, 0, budget.rows - 1) * budget.columns +
                                  std::clamp(column, 0, budget.columns - 1));
}

}  // namespace

void BlobSelection::select(std::vector<Blob>& blobs, const FeatureBudget& budget, int width, int height) {
  std::sort(blobs.begin(), blobs.end(), stronger);
  const auto limit = static_cast<std::size_t>(budget.max_features);
  if (limit == 0 || blobs.size() <= limit) return;

  const auto cells = static_cast<std::size_t>(budget.columns * budget.rows);
  const double quota = std::ceil(budget.cell_share * static_cast<double>(limit) / static_cast<double>(cells));
  taken_.assign(cells, 0);
  kept_.assign(blobs.size(), 0);
  std::size_t count = 0;
  for (std::size_t i = 0; i < blobs.size() && count < limit; ++i) {
    int& taken = taken_[cell_of(blobs[i], budget, width, height)];
    if (taken >= quota) continue;
    ++taken;
    kept_[i] = 1;
    ++count;
  }
  for (std::size_t i = 0; i < blobs.size() && count < limit; ++i) {  // the strongest left over
    if (kept_[i]) continue;
    kept_[i] = 1;
    ++count;
  }
  std::size_t end = 0;
  for (std::size_t i = 0; i < blobs.size(); ++i)
    if (kept_[i]) blobs[end++] = blobs[i];
  blobs.resize(end);
}

}  // namespace lcmslam
