#pragma once
// A constant difference between the clock of the truth and the clock of an estimate, found from the two
// motions themselves.

#include <lcmslam/evaluation/trajectory_error.hpp>

namespace lcmslam {

struct ClockOffsetSearch {
  double range = 0.5;       ///< s; offsets from -range to range are tried
  double step = 0.01;       ///< s, of the coarse search
  double tolerance = 1e-5;  ///< s, of the golden-section search around the best of them
};

/// Added to the estimate's stamps the offset gives the truth's clock (EvaluationSettings::clock_offset).
struct ClockOffset {
  double offset = 0;    ///< s
  double ate = 0;       ///< m, RMSE at that offset, over the compared poses
  double ate_zero = 0;  ///< m, RMSE of the same poses without an offset
  std::size_t compared_poses = 0;
  /// Offsets around it at which the RMSE is at most 5 % above the least: how well this motion determines it.
  double low = 0, high = 0;  ///< s
  bool determined = false;   ///< neither of them lies at an end of the range
};

/// The offset with the least absolute trajectory error. The truth is interpolated, and the poses compared
/// are those that have a truth at every offset of the range, so that the error is a smooth function of the
/// offset: minimised over a coarse grid, then by golden section. Alignment as the settings say, but for
/// first_pose, which one noisy pose would decide: se3 is used then. The settings' own clock offset is not
/// looked at.
/// Throws std::invalid_argument when fewer than 10 poses can be compared.
ClockOffset estimate_clock_offset(const Trajectory& truth, const Trajectory& estimate,
                                  EvaluationSettings settings = {}, const ClockOffsetSearch& search = {});

}  // namespace lcmslam
