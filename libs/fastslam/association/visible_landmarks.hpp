#pragma once
// Which landmarks should be in the image, seen from a pose.

#include <vector>

#include <lcmslam/fastslam/landmarks/landmark_grid.hpp>
#include <lcmslam/fastslam/landmarks/landmark_index.hpp>
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/features/feature.hpp>

namespace lcmslam {

/// A landmark expected in the image: one that is known by its descriptor.
struct VisibleLandmark {
  int slot = 0;
  double x = 0, y = 0;                             ///< predicted pixel
  double range = 0;                                ///< m
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< m, world
};

/// `grid`: has followed the map that the landmarks are seen in.
std::vector<VisibleLandmark> visible_landmarks(const LandmarkGrid& grid, const LandmarkIndex& index,
                                               const Eigen::Isometry3d& T_world_robot,
                                               const FeatureFrame& frame, const FastSlamSettings& settings);
/// The same for a map on its own.
std::vector<VisibleLandmark> visible_landmarks(const ParticleMap& map, const LandmarkIndex& index,
                                               const Eigen::Isometry3d& T_world_robot,
                                               const FeatureFrame& frame, const FastSlamSettings& settings);

}  // namespace lcmslam
