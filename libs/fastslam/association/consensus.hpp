#pragma once
// The robot pose on which most matches of a frame agree, by random sampling (Fischler, Bolles 1981).
// It drops wrong matches before any particle sees them, notices slips that the odometry's covariance
// excludes, and finds the robot again after it was lost.

#include <optional>
#include <vector>

#include <lcmslam/fastslam/landmarks/landmark_filter.hpp>
#include <lcmslam/fastslam/proposal.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {

struct Consensus {
  Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< right perturbation; from the measurements and landmarks
  std::vector<char> inlier;                ///< one for each pair
  int inliers = 0;
};

/// Nothing when fewer than `minimum` pairs agree on any pose. `T_world_prior` is tried first and wins
/// ties. Planar: pose (x, y, heading), from two pairs; otherwise from three.
std::optional<Consensus> find_consensus(const std::vector<ObservedLandmark>& pairs,
                                        const Eigen::Isometry3d& T_world_prior, bool planar, int minimum,
                                        Random& random);

}  // namespace lcmslam
