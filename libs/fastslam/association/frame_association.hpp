#pragma once
// From a frame's features to the observations that every particle uses: match what should be visible,
// keep what one pose explains, notice slips, close loops, find back when lost. The search goes outwards: in
// gates as wide as the motion is uncertain; where that finds less than usual, in gates as wide as a slip;
// then without regard to places among what may be in view; at last by place recognition in the whole map.

#include <optional>
#include <vector>

#include <lcmslam/fastslam/association/consensus.hpp>
#include <lcmslam/fastslam/association/landmark_matcher.hpp>
#include <lcmslam/fastslam/motion_model.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

struct FrameAssociation {
  std::vector<VisibleLandmark> visible;            ///< predicted in view of the best particle
  std::vector<LandmarkMatch> matches;              ///< believed, ordered by slot
  std::vector<LandmarkMatch> known;                ///< by identity, ordered by slot; not verified
  std::vector<LandmarkMatch> rejected;             ///< looked alike, but no common pose explains them
  Motion prior;                                    ///< the motion, corrected and widened after a slip
  bool corrected = false;                          ///< the prior is no longer the odometry's
  std::optional<Eigen::Isometry3d> T_world_found;  ///< pose of the robot found again in the whole map
  bool loop_closed = false;       ///< found again while the odometry was believed: all of it is still true
  std::optional<Consensus> free;  ///< on which most matches agree in space, whatever the plane says
  bool agreed = false;            ///< at least settings.minimum_consensus matches agree on one pose
  bool confirmed = false;  ///< too few have depth to agree on a pose, but the predicted one explains many
  bool slipped = false;
  bool doubtful = false;      ///< the place looks like one seen long ago: not to be mapped anew yet
  bool contradicted = false;  ///< many well-known landmarks should be seen, and nothing agrees with them
  bool hidden = false;        ///< contradicted, but what is measured stands before nearly all of them
};

class FrameAssociator {
 public:
  explicit FrameAssociator(const FastSlamSettings& settings);

  /// All six degrees are free from now on.
  void leave_plane(const FastSlamSettings& settings) { settings_ = settings; }

  /// `T_world_robot` and `map`: the best particle before the motion `prior` (from motion_prior()).
  /// Who may be anywhere seeks landmarks in the whole map at once, who is near where that finds none in view.
  FrameAssociation associate(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                             const Eigen::Isometry3d& T_world_robot, const Motion& prior,
                             const ParticleMap& map, const LandmarkIndex& index,
                             Whereabouts whereabouts = Whereabouts::predicted);

  /// Steps in a row whose features agreed on no pose, nor confirmed the predicted one.
  int steps_without_agreement() const { return steps_without_agreement_; }

 private:
  struct Attempt {
    std::vector<LandmarkMatch> matches;
    std::optional<Consensus> consensus;  // of the 3-D points
    bool supported = false;              // where the prediction has them: more matches than chance gives
    int inliers() const { return consensus ? consensus->inliers : 0; }
  };
  bool slips(const Consensus& consensus, const Eigen::Isometry3d& T_predicted,
             const Matrix6d& covariance) const;
  Attempt agree(std::vector<LandmarkMatch> matches, const std::vector<FeaturePoint>& points,
                const ParticleMap& map, const Eigen::Isometry3d& T_predicted);
  std::optional<Consensus> agree_in_space(const Attempt& attempt, const std::vector<FeaturePoint>& points,
                                          const ParticleMap& map, const Eigen::Isometry3d& T_predicted);
  Attempt search(const std::vector<FeaturePoint>& points, const std::vector<VisibleLandmark>& visible,
                 const FeatureFrame& frame, const Eigen::Isometry3d& T_predicted, const Matrix6d& covariance,
                 const ParticleMap& map, const LandmarkIndex& index);
  bool close_loop(const FeatureFrame& frame, const std::vector<FeaturePoint>& points, const ParticleMap& map,
                  const LandmarkIndex& index, const Eigen::Isometry3d& T_predicted, FrameAssociation& result);
  bool find_back(const std::vector<FeaturePoint>& points, const ParticleMap& map, const LandmarkIndex& index,
                 int minimum, FrameAssociation& result);

  FastSlamSettings settings_;
  Random random_, ground_random_;
  LandmarkGrid grid_;  // of the best particle
  LandmarkMatcher matcher_;
  double usual_inliers_ = 0;  // running mean
  int recognised_ = 0;        // steps in a row that knew the place better than the prediction does
  int steps_without_agreement_ = 0;
};

}  // namespace lcmslam
