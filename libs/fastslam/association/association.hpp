#pragma once
// Features and the landmarks that they show: those of known identity, and the choice of which say most.
// (By descriptor: landmark_matcher.hpp.)

#include <vector>

#include <lcmslam/fastslam/association/usable_features.hpp>
#include <lcmslam/fastslam/landmarks/landmark_index.hpp>
#include <lcmslam/fastslam/landmarks/particle_map.hpp>
#include <lcmslam/fastslam/settings.hpp>

namespace lcmslam {

struct LandmarkMatch {
  int point = 0;  ///< index in the usable features
  int slot = 0;
  int distance2 = 0;  ///< of descriptors
};

void sort_by_slot(std::vector<LandmarkMatch>& matches);

/// Features of known identity whose landmark is in the map, ordered by slot; of several that claim one
/// landmark the likeliest from `T_world_robot`. Whether an identity can be believed, each particle
/// decides by its gate.
std::vector<LandmarkMatch> match_known(const std::vector<FeaturePoint>& points, const ParticleMap& map,
                                       const LandmarkIndex& index, const Eigen::Isometry3d& T_world_robot);

/// At most settings.maximum_observations matches, spread over the image and in each part the best known and
/// best measured first; ordered by slot.
std::vector<LandmarkMatch> select_informative(const std::vector<LandmarkMatch>& matches,
                                              const FeatureFrame& frame,
                                              const std::vector<FeaturePoint>& points, const ParticleMap& map,
                                              const FastSlamSettings& settings);

}  // namespace lcmslam
