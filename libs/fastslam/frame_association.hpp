#pragma once
// From a frame's features to the observations that every particle uses: match what should be visible,
// keep what one pose explains, notice slips, find back when lost.

#include <optional>
#include <vector>

#include "fastslam/association.hpp"
#include "geometry/motion_buffer.hpp"

namespace lcmslam {

struct FrameAssociation {
  std::vector<VisibleLandmark> visible;            ///< predicted in view of the best particle
  std::vector<LandmarkMatch> matches;              ///< believed, ordered by slot
  std::vector<LandmarkMatch> known;                ///< by identity, ordered by slot; not verified
  std::vector<LandmarkMatch> rejected;             ///< looked alike, but no common pose explains them
  Motion prior;                                    ///< the motion, corrected and widened after a slip
  bool corrected = false;                          ///< the prior is no longer the odometry's
  std::optional<Eigen::Isometry3d> T_world_found;  ///< pose of the robot found again in the whole map
  bool agreed = false;  ///< at least settings.minimum_consensus matches agree on one pose
  bool slipped = false;
  bool contradicted = false;  ///< many well-known landmarks should be seen, and nothing agrees with them
};

class FrameAssociator {
 public:
  explicit FrameAssociator(const FastSlamSettings& settings);

  /// `T_world_robot` and `map`: the best particle before the motion `prior` (from motion_prior()).
  FrameAssociation associate(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                             const Eigen::Isometry3d& T_world_robot, const Motion& prior,
                             const ParticleMap& map, const LandmarkIndex& index);

  /// Steps in a row whose features agreed on no pose.
  int steps_without_agreement() const { return steps_without_agreement_; }

 private:
  void find_back(const FeatureFrame& frame, const std::vector<FeaturePoint>& points, const ParticleMap& map,
                 const LandmarkIndex& index, FrameAssociation& result);

  FastSlamSettings settings_;
  Random random_;
  int steps_without_agreement_ = 0;
};

}  // namespace lcmslam
