#include "tools/calibrate/range_choice.hpp"

#include <fmt/format.h>

namespace lcmslam {
namespace {

/// Why the base knows more of the ranges than the fit; empty: it does not. A calibration does not say which
/// ranges its own error was fitted to, so the fit must cover what a wiggle needs.
std::string why_base_stays(const DepthError& base, const RangeErrorFit& fit) {
  if (!base.has_range_error()) return "";
  const bool more_wiggle = base.wiggle == 0 && fit.error.wiggle != 0;
  if (!more_wiggle && (fit.nearest > whole_period.nearest || fit.farthest < whole_period.farthest))
    return fmt::format("here the board was seen at {:.2f} to {:.2f} m alone, not from {:.1f} to {:.1f} m",
                       fit.nearest, fit.farthest, whole_period.nearest, whole_period.farthest);
  if (base.wiggle != 0 && fit.error.wiggle == 0) return "here no wiggle was found";
  if (base.scale != 0 && fit.error.scale == 0) return "its scale is not fitted here";
  return "";
}

}  // namespace

RangeChoice choose_range_error(const DepthError& base, const RangeErrorFit& fit) {
  RangeChoice choice;
  const std::string reason = why_base_stays(base, fit);
  if (!reason.empty())
    choice.kept.push_back(
        "what ranges err by (depth_error: offset, scale, wiggle) stays as it was in the calibration: " +
        reason);
  else if (base.has_tilt())
    choice.kept.emplace_back("depth_error's tilt_x and tilt_y stay as they were: a board does not tell them");
  choice.error = reason.empty() ? fit.error : base;
  choice.error.tilt_x = base.tilt_x, choice.error.tilt_y = base.tilt_y;
  return choice;
}

}  // namespace lcmslam
