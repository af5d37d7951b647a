#include "icp/selection.hpp"

#include <algorithm>

#include "geometry/random.hpp"

namespace lcmslam {
namespace {

// Every k-th point, k a fraction: exactly `count` of them.
void keep_uniform(std::vector<std::size_t>& indices, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) indices[i] = indices[i * indices.size() / count];
}

// The first `count` places of a Fisher-Yates shuffle, back in ascending order.
void keep_random(std::vector<std::size_t>& indices, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  for (std::size_t i = 0; i < count; ++i)
    std::swap(indices[i], indices[i + static_cast<std::size_t>(random.below(indices.size() - i))]);
  std::sort(indices.begin(), indices.begin() + static_cast<std::ptrdiff_t>(count));
}

}  // namespace

std::vector<std::size_t> select_points(const Cloud& source, const RegistrationSettings& settings) {
  std::vector<std::size_t> indices;
  indices.reserve(source.size());
  for (std::size_t i = 0; i < source.size(); ++i)
    if (source.points[i].allFinite()) indices.push_back(i);

  const auto count = static_cast<std::size_t>(std::max(settings.selected_points, 0));
  if (settings.selection == SelectionKind::all || indices.size() <= count) return indices;
  if (settings.selection == SelectionKind::uniform) keep_uniform(indices, count);
  if (settings.selection == SelectionKind::random) keep_random(indices, count, settings.seed);
  indices.resize(count);
  return indices;
}

}  // namespace lcmslam
