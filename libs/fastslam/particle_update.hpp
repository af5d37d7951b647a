#pragma once
// FastSLAM's inner loop, for up to four particles side by side: each proposes a pose, is weighed by what it
// observes from there, and updates the landmarks that it believes (Montemerlo 2003; thesis 2.3).

#include <memory>
#include <vector>

#include <lcmslam/fastslam/association/association.hpp>
#include <lcmslam/fastslam/particle.hpp>
#include <lcmslam/fastslam/proposal.hpp>

namespace lcmslam {

/// Of one step; keeps its buffers; one a thread. Borrows `settings` and `observed`.
class ParticleUpdate {
 public:
  /// `motion_covariance`: of the priors, right perturbation. `observed`: landmarks of the map, with the
  /// usable features that show them.
  ParticleUpdate(const FastSlamSettings& settings, const Matrix6d& motion_covariance,
                 const std::vector<LandmarkMatch>& observed, const std::vector<FeaturePoint>& points);

  /// `count` particles, 1 to lane_count; T_world_prior[lane_count], those beyond `count` repeat the last one.
  /// A particle's result depends on itself and its own random stream alone.
  void apply(Particle* particles, Random* streams, int count, const Eigen::Isometry3d* T_world_prior,
             Verdict* verdicts);

 private:
  void load_maps(const Particle* particles, int count);
  void weigh_and_update(Particle& particle, int lane, Verdict& verdict) const;
  bool weigh(double distance2, double log_peak, double& log_weight, Verdict& verdict) const;

  const FastSlamSettings& settings_;
  const std::vector<LandmarkMatch>& observed_;
  double gate2_;           // d^2 at which exp(-d^2/2) equals the gate
  double added_variance_;  // m^2, of an updated landmark
  std::unique_ptr<Proposal> proposal_;
  ObservedLanes seen_;
  std::vector<const CompactLandmark*> stored_;
  std::vector<LearnedLanes> learned_;
};

}  // namespace lcmslam
