#pragma once
// The covariances that the filter publishes. Two questions, two answers: how far may the robot be from where
// the map says, and how well does it stand among the landmarks in sight?

#include <vector>

#include <lcmslam/fastslam/error_ensemble.hpp>
#include <lcmslam/fastslam/particle_set.hpp>
#include <lcmslam/fastslam/sensor_error.hpp>

namespace lcmslam {

/// A step of the filter, as the errors of its measurements follow from it.
struct MeasuredStep {
  const FeatureFrame& frame;
  const std::vector<FeaturePoint>& points;
  const ParticleMap& map;  ///< of the best particle, after the step
  const LandmarkIndex& index;
  const Eigen::Isometry3d& T_world_robot;  ///< of the best particle
  const Vector6d& twist;                   ///< m/s, rad/s, body frame
};

class PoseCovariance {
 public:
  explicit PoseCovariance(const FastSlamSettings& settings);

  /// From now on the pose has six degrees of freedom.
  void leave_plane();
  /// The robot moved; covariance of this step alone.
  void move(const Motion& step) { ensemble_.move(step); }
  /// The robot was found elsewhere in its map, known like this.
  void find(const Matrix6d& covariance) { ensemble_.find(covariance); }
  /// The pose rests on these landmarks, and they learned. `prior`: as the filter had it before it looked;
  /// nothing at its first step.
  void observe(const std::vector<LandmarkMatch>& accepted, const MeasuredStep& step,
               const std::optional<Matrix6d>& prior);
  /// Landmarks are made.
  void create(const std::vector<LandmarkMatch>& created, const MeasuredStep& step);

  /// Of the estimate exp(xi) as the robot's pose seen from its first one; body frame.
  Matrix6d from_start(const ParticleSet& particles, const std::vector<double>& weights,
                      const ParticleSet::Estimate& estimate, const Eigen::Isometry3d& T_robot_camera) const;
  /// Of the estimate in the world in which the landmarks stand; body frame.
  Matrix6d in_map(const ParticleSet::Estimate& estimate) const { return estimate.spread + mount_; }
  /// Of a landmark's place seen from the robot's first pose, m^2, world.
  Eigen::Matrix3d of_landmark(int slot, const ParticleSet& particles) const;

 private:
  std::vector<EnsembleObservation> with_errors(const std::vector<LandmarkMatch>& matches,
                                               const MeasuredStep& step);

  Matrix6d by_mount(const Eigen::Isometry3d& T_start_robot, const Eigen::Isometry3d& T_robot_camera) const;

  MountErrorSettings mount_error_;
  Matrix6d mount_ = Matrix6d::Zero();  // of the head's place itself
  bool planar_;
  SensorError sensor_error_;
  ErrorEnsemble ensemble_;
};

}  // namespace lcmslam
