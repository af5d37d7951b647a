#pragma once
// Which feature shows which landmark. Descriptors decide, but only against landmarks that can be seen from
// the predicted pose, each where it should be: so the ratio test stays meaningful however large the map
// grows. The whole map is searched only to find back after having been lost.

#include <vector>

#include <lcmslam/fastslam/association/association.hpp>
#include <lcmslam/fastslam/association/visible_landmarks.hpp>
#include <lcmslam/features/descriptor_search.hpp>
#include <lcmslam/features/guided_matching.hpp>

namespace lcmslam {

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

}  // namespace lcmslam
