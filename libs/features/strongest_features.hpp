#pragma once
// What a keyframe keeps of its features.

#include <algorithm>
#include <numeric>
#include <vector>

#include <lcmslam/features/feature.hpp>

namespace lcmslam {

/// Indices of at most `count` features with the largest response, strongest first; of equals the first.
inline std::vector<std::size_t> strongest(const std::vector<Feature>& features, int count) {
  std::vector<std::size_t> order(features.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return features[a].response > features[b].response; });
  if (order.size() > static_cast<std::size_t>(count)) order.resize(static_cast<std::size_t>(count));
  return order;
}

/// The frame with those alone, in their order.
inline FeatureFrame strongest(FeatureFrame frame, int count) {
  if (frame.features.size() <= static_cast<std::size_t>(count)) return frame;
  std::vector<std::size_t> kept = strongest(frame.features, count);
  std::sort(kept.begin(), kept.end());
  std::vector<Feature> features;
  features.reserve(kept.size());
  for (const std::size_t i : kept) features.push_back(frame.features[i]);
  frame.features = std::move(features);
  return frame;
}

}  // namespace lcmslam
