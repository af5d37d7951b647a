#pragma once
// Whether an estimate errs as much as it says: the normalised estimation error squared
//
//   NEES = e^T P^-1 e,   e = log(T_estimate^-1 T_truth),   P: published with the estimate, of T_estimate
//   exp(e)
//
// averages to the number of e's components when P is honest (Bar-Shalom, Li and Kirubarajan, "Estimation with
// Applications to Tracking and Navigation", 2001, 5.4); above, the estimate is overconfident. A path in the
// plane is judged by (x, y, heading).

#include <optional>

#include <lcmslam/evaluation/trajectory_error.hpp>

namespace lcmslam {

/// What of the worlds is fitted: nothing, x, y and heading (they share the ground plane), or everything.
enum class WorldFit { none, ground, space };

/// What is not known between truth and estimate, and is fitted by the covariances (least sum of NEES).
struct ConsistencyFit {
  /// Where the estimate's world lies in the truth's. A fit of the paths would not do: the first pose is known
  /// to a millimetre in its own world, and stands some centimetres beside the truth then.
  WorldFit world = WorldFit::none;
  bool body = false;  ///< where the truth's body sits on the estimate's
};

/// Nothing when no pose brings a positive definite covariance.
std::optional<Consistency> consistency(std::vector<MatchedPose> matches, const ConsistencyFit& fit);

}  // namespace lcmslam
