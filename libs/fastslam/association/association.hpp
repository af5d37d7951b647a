#pragma once
// Which feature shows which landmark. Descriptors decide, but only against landmarks that can be seen from
// the predicted pose, each where it should be: so the ratio test stays meaningful however large the map
// grows. The whole map is searched only to find back after having been lost.

#include <vector>

#include <lcmslam/fastslam/landmarks/landmark_grid.hpp>
#include <lcmslam/fastslam/landmarks/landmark_index.hpp>
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/features/descriptor_search.hpp>
#include <lcmslam/features/feature.hpp>
#include <lcmslam/features/guided_matching.hpp>

namespace lcmslam {

/// A feature that the filter can use, as a measurement in the robot frame, its covariance inflated. It
/// borrows the frame's T_robot_camera.
struct FeaturePoint {
  int feature = 0;                ///< index in FeatureFrame::features
  double range = 0;               ///< m from the sensor; 0 for a bearing
  std::int32_t landmark_id = -1;  ///< known identity; -1: the descriptor tells
  Measurement measurement;

  bool is_bearing() const { return measurement.kind == MeasurementKind::bearing; }
};

/// The usable features of a frame, strongest response first: finite 3-D points in range, pixels without depth
/// (settings.use_bearings), and planar or range-bearing measurements of known identity. The order does not
/// depend on the frame's.
std::vector<FeaturePoint> usable_features(const FeatureFrame& frame, const FastSlamSettings& settings);

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

struct LandmarkMatch {
  int point = 0;  ///< index in the usable features
  int slot = 0;
  int distance2 = 0;  ///< of descriptors
};

/// Matches features without a known identity, ordered by slot. Keeps its buffers; one a thread.
class LandmarkMatcher {
 public:
  /// `settings`: of everywhere().
  explicit LandmarkMatcher(const SearchSettings& settings = {}) : search_(settings) {}

  /// Takes the features of a frame, but for those that are `matched` already.
  void begin(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
             const std::vector<LandmarkMatch>& matched = {});

  /// Each landmark is sought where it should be seen from a pose (`covariance`: of the robot, right
  /// perturbation) of limited certainty: GuidedMatcher.
  std::vector<LandmarkMatch> guided(const std::vector<VisibleLandmark>& visible, const ParticleMap& map,
                                    const LandmarkIndex& index, const Eigen::Isometry3d& T_world_robot,
                                    const Matrix6d& covariance, const FastSlamSettings& settings);
  /// Of the last guided(): more matches than chance gives.
  bool supported() const { return supported_; }

  /// By descriptors alone, among landmarks that may be in view.
  std::vector<LandmarkMatch> among(const std::vector<VisibleLandmark>& visible, const ParticleMap& map,
                                   const LandmarkIndex& index, const FastSlamSettings& settings);
  /// By descriptors alone, in the whole map: for finding back.
  std::vector<LandmarkMatch> everywhere(const ParticleMap& map, const LandmarkIndex& index,
                                        const FastSlamSettings& settings);

 private:
  std::vector<LandmarkMatch> distinct(const std::vector<Neighbours>& nearest, const ParticleMap& map,
                                      const FastSlamSettings& settings) const;

  FeatureFrame sought_;        // the features at work
  std::vector<int> point_of_;  // their index in the usable features
  std::vector<MapPoint> points_;
  std::vector<const CompactLandmark*> stored_;
  std::vector<int> slots_;
  GuidedMatcher guided_;
  DescriptorSearch search_;
  bool supported_ = false;
};

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
