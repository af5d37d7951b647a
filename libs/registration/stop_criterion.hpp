#pragma once
// When a registration has arrived.

#include <vector>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/registration/registration_settings.hpp>

namespace lcmslam {

class StopCriterion {
 public:
  explicit StopCriterion(const RegistrationSettings& settings) : settings_(settings) {}

  /// The step from before to after is below both epsilons, or the last two RMS errors (m) differ by less than
  /// epsilon_rms (thesis algorithm 3.1).
  bool arrived(const Eigen::Isometry3d& before, const Eigen::Isometry3d& after,
               const std::vector<double>& rms) const;

 private:
  RegistrationSettings settings_;
};

}  // namespace lcmslam
