#pragma once
// Which landmarks still exist, and where new ones are needed. Decided once for all particles, from the
// best one's view.

#include <vector>

#include <lcmslam/fastslam/association/association.hpp>
#include <lcmslam/fastslam/association/visible_landmarks.hpp>

namespace lcmslam {

/// Counts observations and misses; returns how many landmarks died. `contradicted` are slots of known
/// identity that the best particle rejected: a misread identity or a landmark that was moved dies by them,
/// and is made anew where it is now. `matches` were seen (from `T_world_robot`, the best particle's pose
/// after the step). A landmark counts as missed only where the frame proves that it should have shown: well
/// inside the image, seen before from about there, and with a measured point beside it that is not in front
/// of it.
int update_existence(LandmarkIndex& index, const ParticleMap& map, const FeatureFrame& frame,
                     const std::vector<FeaturePoint>& points, const std::vector<VisibleLandmark>& visible,
                     const std::vector<LandmarkMatch>& matches, const std::vector<int>& contradicted,
                     const Eigen::Isometry3d& T_world_robot, const FastSlamSettings& settings);

/// Usable features (indices into `points`) that shall become landmarks: the strongest that matched
/// nothing, where the image has fewer than settings.cell_capacity landmarks in a cell; and all known
/// identities that have no landmark yet. Where the frame matches half as many landmarks as the filter uses at
/// most, landmarks of a former visit that are in view count in their cell whether they match or not: who
/// comes by again and again would make new ones each time, and the map would grow. Where so many are of a
/// former visit, one in a cell is enough.
std::vector<int> choose_new_landmarks(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                                      const std::vector<VisibleLandmark>& visible,
                                      const std::vector<LandmarkMatch>& matches, const LandmarkIndex& index,
                                      const Eigen::Isometry3d& T_world_robot,
                                      const FastSlamSettings& settings);

}  // namespace lcmslam
