#pragma once
// Do two trajectories tell the poses of the same body? A camera's path and its robot's differ by a constant
// rotation (the axes) and a constant lever (the mount), which no alignment of their worlds takes away:
//
//   T_world_truth(i) = X T_world_estimate(i) Y
//
// X: the worlds' alignment; Y: where the truth's body sits on the estimate's. With Y = I both are the same.

#include <array>
#include <optional>
#include <string>

#include <lcmslam/evaluation/trajectory_error.hpp>

namespace lcmslam {

struct BodyOffset {
  Eigen::Isometry3d T_estimate_truth = Eigen::Isometry3d::Identity();  ///< Y; what is not found is identity
  bool rotated = false;                                                ///< a constant rotation was found
  bool displaced = false;                                              ///< a constant lever was found
  double angle = 0;                                                    ///< rad, of that rotation
  double scatter = 0;                      ///< rad, RMS of the rotations that are left
  double lever = 0;                        ///< m
  double rmse_without = 0, rmse_with = 0;  ///< m, of the positions, without and with the lever

  /// Whose axes are whose, "+x", "-z" ...: along which axis of the estimate's body the truth's x, y and z
  /// lie.
  std::array<std::string, 3> axes() const;
};

/// The cameras' convention (x right, y down, z forward) against the robots' (x forward, y left, z up).
enum class BodyPair { same, truth_is_camera, estimate_is_camera, other };
BodyPair body_pair(const BodyOffset& offset);

/// Nothing when the bodies are the same, as far as the motion shows: a rotation counts from 8 degrees, and
/// only where no other alignment of the worlds explains it; a lever from 3 cm, and only where it takes away
/// more than half of the error. `matches`: as associate() gives them, aligned or not.
std::optional<BodyOffset> find_body_offset(const std::vector<MatchedPose>& matches);

}  // namespace lcmslam
