#pragma once
// The covariance that the filter publishes: the particles' spread, what they share of the past and what no
// particle knows of.

#include <vector>

#include <lcmslam/fastslam/particle_set.hpp>
#include <lcmslam/fastslam/smoothing/shared_error.hpp>

namespace lcmslam {

class PoseCovariance {
 public:
  explicit PoseCovariance(const FastSlamSettings& settings);

  /// The pose rests on these landmarks.
  void observe(const std::vector<LandmarkMatch>& accepted, const ParticleSet::Estimate& estimate) {
    shared_error_.observe(accepted, minimum_consensus_, estimate.T_world_robot, estimate.spread);
  }
  /// Landmarks are made.
  void create(const std::vector<LandmarkMatch>& created) { shared_error_.create(created); }

  /// Of the estimate exp(xi) as the robot's pose seen from its first one; body frame.
  Matrix6d from_start(const ParticleSet& particles, const std::vector<double>& weights,
                      const ParticleSet::Estimate& estimate) const;
  /// Of the estimate in the world in which the landmarks stand; body frame.
  Matrix6d in_map(const ParticleSet::Estimate& estimate) const { return estimate.spread + unmodelled_; }

 private:
  int minimum_consensus_;
  Matrix6d unmodelled_ = Matrix6d::Zero();  // of the settings' shared sigmas
  SharedError shared_error_;
};

}  // namespace lcmslam
