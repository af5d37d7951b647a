#include <lcmslam/surf/adaptive_threshold.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {

AdaptiveThreshold::AdaptiveThreshold(const AdaptiveThresholdSettings& settings)
    : settings_(settings), value_(settings.start) {
  const auto& s = settings_;
  check(s, "SURF");
  if (!(s.lowest <= s.start && s.start <= s.highest))
    throw std::invalid_argument("SURF: of the thresholds, lowest <= start <= highest must hold, not " +
                                std::to_string(s.lowest) + " <= " + std::to_string(s.start) +
                                " <= " + std::to_string(s.highest));
  if (s.wanted < 1) throw std::invalid_argument("SURF: the number of blobs wanted must be positive");
}

void AdaptiveThreshold::observe(int blobs) {
  // The number of blobs falls about with the threshold's inverse. Half of the way in the logarithm, and at
  // most an octave, keeps one odd frame from upsetting the next.
  constexpr double tolerance = 1.25, largest_step = 2;
  const double ratio = std::max(blobs, 1) / static_cast<double>(settings_.wanted);
  if (ratio < tolerance && ratio > 1 / tolerance) return;
  const double step = std::clamp(std::sqrt(ratio), 1 / largest_step, largest_step);
  value_ = std::clamp(value_ * step, settings_.lowest, settings_.highest);
}

}  // namespace lcmslam
