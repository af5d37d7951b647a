#pragma once
// What an adjustment moves, and where it stands: the head, the keyframes, the landmarks, and the curve of
// what all ranges err by.

#include <array>
#include <vector>

#include <lcmslam/calibration/self/head_parameters.hpp>
#include <lcmslam/calibration/self/range_curve.hpp>
#include <lcmslam/calibration/self/scene_observations.hpp>

namespace lcmslam {

class BundleState {
 public:
  BundleState(HeadModel& head, SceneObservations& observed);

  /// A landmark in a keyframe's colour camera, `seconds` after the keyframe's moment.
  Eigen::Vector3d seen_by_colour(std::size_t keyframe, std::size_t landmark, double seconds) const;
  /// Poses begin anew where the solution put them, and velocities follow them.
  void take_over();

  HeadModel& model;
  SceneObservations& scene;
  RangeCurve curve;
  double rational[3] = {};                   ///< k4 k5 k6 of the colour camera's lens
  std::vector<Eigen::Isometry3d> starts;     ///< T_camera_world
  std::vector<std::array<double, 9>> moved;  ///< what keyframes have moved since (residuals.hpp)
  std::vector<Vector6d> told_twists;         ///< by odometry, as much larger as the keyframes say

 private:
  std::vector<Vector6d> first_twists_;  // as they were at first
};

}  // namespace lcmslam
