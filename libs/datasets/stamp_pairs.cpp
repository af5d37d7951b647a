#include <lcmslam/datasets/stamp_pairs.hpp>

#include <algorithm>
#include <cstdlib>
#include <tuple>

namespace lcmslam {

std::vector<std::pair<std::size_t, std::size_t>> pair_by_stamps(const std::vector<Utime>& a,
                                                                const std::vector<Utime>& b,
                                                                Utime max_difference) {
  std::vector<std::tuple<Utime, std::size_t, std::size_t>> candidates;
  std::size_t first = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    while (first < b.size() && b[first] < a[i] - max_difference) ++first;
    for (std::size_t j = first; j < b.size() && b[j] <= a[i] + max_difference; ++j)
      candidates.emplace_back(std::abs(a[i] - b[j]), i, j);
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<bool> a_used(a.size()), b_used(b.size());
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const auto& [difference, i, j] : candidates) {
    if (a_used[i] || b_used[j]) continue;
    a_used[i] = b_used[j] = true;
    pairs.emplace_back(i, j);
  }
  return pairs;
}

}  // namespace lcmslam
