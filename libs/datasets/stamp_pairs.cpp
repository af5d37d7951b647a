#include <lcmslam/datasets/stamp_pairs.hpp>

#include <algorithm>
#include <cstdlib>
#include <tuple>

namespace lcmslam {

std::vector<std::pair<std::size_t, std::size_t>> pair_by_stamps(const std::vector<Utime>& colour,
                                                                const std::vector<Utime>& depth,
                                                                Utime depth_offset, Utime max_difference) {
  std::vector<std::tuple<Utime, std::size_t, std::size_t>> candidates;
  std::size_t first = 0;
  for (std::size_t i = 0; i < colour.size(); ++i) {
    const Utime wanted = colour[i] - depth_offset;  // depth's stamp of that moment
    while (first < depth.size() && depth[first] < wanted - max_difference) ++first;
    for (std::size_t j = first; j < depth.size() && depth[j] <= wanted + max_difference; ++j)
      candidates.emplace_back(std::abs(wanted - depth[j]), i, j);
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<bool> colour_used(colour.size()), depth_used(depth.size());
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const auto& [difference, i, j] : candidates) {
    if (colour_used[i] || depth_used[j]) continue;
    colour_used[i] = depth_used[j] = true;
    pairs.emplace_back(i, j);
  }
  return pairs;
}

}  // namespace lcmslam
