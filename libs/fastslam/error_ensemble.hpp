#pragma once
// By how much the filter may be wrong, told by 64 errors that it might have made.
//
// Particles forget with every resampling what they did not know of their past (Bailey, Nieto and Nebot 2006,
// "Consistency of the FastSLAM algorithm"), and no particle knows of errors that all measurements share. So
// the filter's own equations are gone through once more, linear and for errors in the place of values: each
// member of the ensemble is one assumed history of everything that errs, and carries the error of the pose
// and of every landmark that follows from it through the gains that the filter applied,
//
//   motion     e <- Ad(T^-1) e + q                                        T_true = T exp(e)
//   pose       e <- L^-1 (Q^-1 e + sum J^T G^T S^-1 (G f + v)) + d,       L = Q^-1 + sum J^T G^T S^-1 G J
//   landmark   f <- f - K (G (f - J e) + v);   a new one:  f = J e - v    m_true = m + f, robot frame
//
// with v the errors of this member's sensor (sensor_error.hpp), q those of its odometry, and d the draw by
// which particles differ, as far as weights do not choose among draws and the mean does not cancel them
// (`draw_share`: a twentieth of their variance in the plane; most of it with six degrees of freedom,
// `free_draw_share`). Mean squares over the members are covariances (Evensen 2003, "The
// Ensemble Kalman Filter", has the statistics). So all correlations are there: the pose in the map's frame
// grows less certain with the way into new ground, as a walk or steadily where the error is a systematic one,
// and is as good as it was where old landmarks are seen again.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include <lcmslam/fastslam/landmarks/landmark_filter.hpp>
#include <lcmslam/fastslam/sensor_error.hpp>
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {

/// A landmark that the filter learned from, or made.
struct EnsembleObservation {
  int slot = 0;
  Measurement measurement;    ///< with the covariance that the filter believed
  LandmarkGaussian landmark;  ///< after the step; m, world
  EnsembleVectors error;      ///< of the measurement's value, for each member
};

class ErrorEnsemble {
 public:
  explicit ErrorEnsemble(const FastSlamSettings& settings);

  /// From now on the pose has six degrees of freedom.
  void leave_plane();
  /// The robot moved; covariance of the motion alone.
  void move(const Motion& step);
  /// The robot was found elsewhere in its map, known like this (body frame): where it was believed to be says
  /// nothing any more.
  void find(const Matrix6d& covariance) { robot_ = drawn(covariance); }
  /// From `T_world_robot` the pose was found by landmarks, and they learned. `prior`: covariance that the
  /// filter gave the pose before it looked, body frame; nothing: nobody knew anything of it.
  void observe(const std::vector<EnsembleObservation>& accepted, const Eigen::Isometry3d& T_world_robot,
               const std::optional<Matrix6d>& prior);
  /// Landmarks were made from there.
  void create(const std::vector<EnsembleObservation>& created, const Eigen::Isometry3d& T_world_robot);

  /// Of the robot's pose exp(xi), in the frame of its first one; body frame.
  Matrix6d pose() const;
  /// m^2, world.
  Eigen::Matrix3d landmark(int slot) const;

 private:
  using Twists = Eigen::Matrix<float, 6, ensemble_size, Eigen::RowMajor>;
  Twists drawn(const Matrix6d& covariance);
  Matrix6d restricted(const Matrix6d& covariance) const;

  bool planar_;
  double draw_share_, free_draw_share_;
  double landmark_variance_;  // that the filter adds after each update
  Random stream_;
  Twists robot_ = Twists::Zero();
  std::vector<EnsembleVectors> landmarks_;  // by slot
};

}  // namespace lcmslam
