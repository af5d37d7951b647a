#pragma once
#include <optional>

namespace lcmslam {

/// Seconds that the rest of a work takes of which this share took so long; nothing as long as too little of
/// it was seen: what comes at the begin comes in one go.
inline std::optional<double> time_left(double elapsed, double share) {
  constexpr double least_elapsed = 5, least_share = 0.03;
  if (elapsed < least_elapsed || share < least_share) return std::nullopt;
  return elapsed / share - elapsed;
}

}  // namespace lcmslam
