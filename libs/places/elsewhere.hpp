#pragma once
// Of points that look alike in a map and for who asks: what speaks for another place.

#include <algorithm>
#include <numeric>
#include <vector>

#include <lcmslam/features/rigid_ransac.hpp>

namespace lcmslam {

/// Indices into `pairs`, ascending, of those that the best pose elsewhere explains; none: there is no such
/// pose. `is_here(T_a_b)`: it is the place that is known already. What is mapped often comes again, perhaps
/// before another place, so what such a pose explains goes and the rest is asked, a few times.
template <class IsHere>
std::vector<int> explained_elsewhere(std::vector<PointPair> pairs, const RigidRansacSettings& settings,
                                     const IsHere& is_here) {
  constexpr int most_looks = 4;
  std::vector<int> number(pairs.size());  // of what is left, as the caller counts
  std::iota(number.begin(), number.end(), 0);
  for (int look = 0; look < most_looks; ++look) {
    Random random(1);
    const RigidRansacResult best = align_ransac(pairs, settings, random);
    if (!best.success) return {};
    if (!is_here(best.T_a_b)) {
      std::vector<int> explained;
      for (const int i : best.inliers) explained.push_back(number[static_cast<std::size_t>(i)]);
      return explained;
    }
    std::size_t left = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (std::binary_search(best.inliers.begin(), best.inliers.end(), static_cast<int>(i))) continue;
      pairs[left] = pairs[i];
      number[left++] = number[i];
    }
    pairs.resize(left);
    number.resize(left);
  }
  return {};
}

}  // namespace lcmslam
