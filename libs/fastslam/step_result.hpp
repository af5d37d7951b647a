#pragma once
// What a step of FastSLAM finds: the pose and how sure it is, and what became of the frame's features.

#include <cstdint>
#include <vector>

#include <lcmslam/geometry/ground_plane.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

enum class TrackStatus {
  initialising,  ///< first landmarks: the pose is the world's origin
  tracking,      ///< observations agree on the pose
  predicting,    ///< too few observations: the pose rests on odometry
  lost,        ///< measurements have not told where in the map for most of a second, the odometry is lost, or
               ///< no features fit for several steps: the pose follows the odometry that there is
  relocalised  ///< found back in this step: the pose may have jumped
};

struct ObservationReport {
  int feature = 0;  ///< index in FeatureFrame::features
  std::int64_t landmark = 0;
  bool accepted = false;  ///< by the best particle
};

/// What became of a feature that has a landmark.
enum class AssociationOutcome {
  accepted,  ///< the landmark was seen again, and the best particle learned from it
  unused,    ///< seen again, but settings.maximum_observations others say more
  rejected,  ///< looks like the landmark, but the agreed pose or the best particle's gate says no
  created    ///< a new landmark; the feature may have been rejected by another before
};

struct AssociationReport {
  int feature = 0;  ///< index in FeatureFrame::features
  std::int64_t landmark = 0;
  AssociationOutcome outcome = AssociationOutcome::accepted;
};

struct StepResult {
  Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();  ///< estimate that the settings name
  Eigen::Isometry3d T_world_best = Eigen::Isometry3d::Identity();  ///< of the best particle: fits landmarks()
  /// Of T_world_robot exp(xi) as the robot's pose seen from its first one; body frame.
  Matrix6d covariance = Matrix6d::Zero();
  Matrix6d spread = Matrix6d::Zero();  ///< of the particles about T_world_robot, body frame
  /// The same pose in two parts, T_world_robot = T_world_local * T_local_robot (local_frame.hpp): the second
  /// one never jumps.
  Eigen::Isometry3d T_local_robot = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_world_local = Eigen::Isometry3d::Identity();
  Matrix6d local_covariance = Matrix6d::Zero();       ///< against the landmarks in sight, body frame
  Matrix6d correction_covariance = Matrix6d::Zero();  ///< of T_world_local exp(xi), T_local_robot being exact
  double effective_sample_size = 0;
  int best = 0;  ///< index of the best particle after this step
  TrackStatus status = TrackStatus::initialising;
  int offered = 0;               ///< features with a usable 3-D point
  int matched = 0;               ///< landmarks seen again
  int used = 0;                  ///< of these, in the filter
  int rejected = 0;              ///< look-alikes that the pose or the best particle rejected
  int created = 0, removed = 0;  ///< landmarks
  bool loop_closed = false;  ///< relocalised where only drift had led it astray: the map is deformed to fit
  double unplaced = 0;       ///< s since features first contradicted the landmarks that should be there, and
                             ///< nothing was recognised: somebody has carried the robot
  double adrift = 0;     ///< s of frames that show enough and nothing known, of a robot that may be anywhere
  bool slipped = false;  ///< observations contradicted the odometry, and won
  Floor floor = Floor::plane;  ///< of a robot on wheels: what measurements leave of the plane
  bool resampled = false;
  bool rejuvenated = false;
  bool motion_usable = true;  ///< false: odometry was not finite; the step went on without
  double mean_distance2 = 0;  ///< of accepted observations at the best particle; about 3 when consistent
  std::vector<ObservationReport> observations;  ///< what the particles were weighed by
  std::vector<AssociationReport> associations;  ///< of all features that have a landmark, for display
};

}  // namespace lcmslam
