#pragma once
// Which features of keyframes are one landmark: matched in pairs that agree on one motion, joined over many.

#include <utility>
#include <vector>

#include <lcmslam/calibration/self/scene_observations.hpp>
#include <lcmslam/features/feature.hpp>
#include <lcmslam/features/matching.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

class LandmarkTracks {
 public:
  static constexpr std::size_t fewest_sightings = 3;
  /// `gate`: pixels that a match may miss by.
  LandmarkTracks(const RgbdCalibration& calibration, double gate, std::uint64_t seed);

  /// The next keyframe.
  void add(const FeatureFrame& features, const Eigen::Isometry3d& T_world_camera);
  /// The last keyframe's features with an earlier one's.
  void match_last(std::size_t earlier);

  /// Of at least three keyframes each, those of most keyframes first, `most` at most.
  std::vector<SightedLandmark> landmarks(std::size_t most) const;

 private:
  struct Node {
    std::size_t keyframe, feature;
    std::size_t parent;                  // of a tree that stands for a landmark
    std::vector<std::size_t> keyframes;  // of the whole tree, sorted; at its root
  };
  std::size_t root(std::size_t node) const;
  void join(std::size_t a, std::size_t b);

  RgbdCalibration calibration_;
  double gate_;
  Random random_;
  Matcher matcher_;
  std::vector<FeatureFrame> frames_;
  std::vector<Eigen::Isometry3d> poses_;
  std::vector<std::size_t> first_;  // node of each keyframe
  std::vector<Node> nodes_;
};

}  // namespace lcmslam
