#pragma once
// Which feature shows which landmark. Descriptors decide, but only against landmarks that can be seen
// from the predicted pose: so the ratio test stays meaningful however large the map grows. The whole
// map is searched only to find back after having been lost.

#include <vector>

#include "fastslam/landmark_filter.hpp"
#include "fastslam/landmark_index.hpp"
#include "fastslam/settings.hpp"
#include "geometry/random.hpp"
#include "surf/feature.hpp"

namespace lcmslam {

/// A feature that the filter can use, as a measurement in the robot frame, its covariance inflated.
struct FeaturePoint {
  int feature = 0;                ///< index in FeatureFrame::features
  double range = 0;               ///< m from the sensor
  std::int32_t landmark_id = -1;  ///< known identity; -1: the descriptor tells
  Measurement measurement;
};

/// The usable features of a frame, strongest response first: finite 3-D points in range, and planar or
/// range-bearing measurements of known identity. The order does not depend on the frame's.
std::vector<FeaturePoint> usable_features(const FeatureFrame& frame, const FastSlamSettings& settings);

/// A landmark expected in the image: one that is known by its descriptor.
struct VisibleLandmark {
  int slot = 0;
  double x = 0, y = 0;                             ///< predicted pixel
  double range = 0;                                ///< m
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< m, world
};

std::vector<VisibleLandmark> visible_landmarks(const ParticleMap& map, const LandmarkIndex& index,
                                               const Eigen::Isometry3d& T_world_robot,
                                               const FeatureFrame& frame, const FastSlamSettings& settings);

struct LandmarkMatch {
  int point = 0;  ///< index in the usable features
  int slot = 0;
  int distance2 = 0;  ///< of descriptors
};

/// Mutual nearest descriptors of equal Laplacian sign within `radius` pixels that pass the ratio test;
/// ordered by slot.
std::vector<LandmarkMatch> match_visible(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                                         const std::vector<VisibleLandmark>& visible,
                                         const LandmarkIndex& index, double radius,
                                         const FastSlamSettings& settings);

/// Features of known identity whose landmark is in the map, ordered by slot; of several that claim one
/// landmark the likeliest from `T_world_robot`. Whether an identity can be believed, each particle
/// decides by its gate.
std::vector<LandmarkMatch> match_known(const std::vector<FeaturePoint>& points, const ParticleMap& map,
                                       const LandmarkIndex& index, const Eigen::Isometry3d& T_world_robot);

/// Some features (drawn at random so that their number times the map's size stays bounded) against
/// the whole map: for finding back. Ordered by slot.
std::vector<LandmarkMatch> match_all(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                                     const ParticleMap& map, const LandmarkIndex& index,
                                     const FastSlamSettings& settings, Random& random);

/// At most settings.maximum_observations matches, spread over the image and in each part the best
/// known and best measured first; ordered by slot.
std::vector<LandmarkMatch> select_informative(const std::vector<LandmarkMatch>& matches,
                                              const FeatureFrame& frame,
                                              const std::vector<FeaturePoint>& points, const ParticleMap& map,
                                              const FastSlamSettings& settings);

}  // namespace lcmslam
