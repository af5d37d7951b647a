#pragma once
// Has the camera been here before? Keyframes whose SURF descriptors look alike are loop candidates (each
// feature votes for the keyframes of its nearest neighbours). A candidate is verified by geometry: RANSAC
// over matched features, then ICP of the two clouds, with every direction's certainty.

#include <memory>
#include <optional>
#include <vector>

#include <lcmslam/features/descriptor_search.hpp>
#include <lcmslam/features/matching.hpp>
#include <lcmslam/features/rigid_ransac.hpp>
#include <lcmslam/pose_graph/pose_graph.hpp>
#include <lcmslam/registration/registration.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct LoopFinderSettings {
  int indexed_features = 200;
  double max_descriptor_distance = 0.35;
  int min_votes = 12;
  int candidates = 2;
  int min_inliers = 15;
  double min_overlap = 0.30;
  double min_inlier_share = 0.6;
  double max_disagreement = 5;
  double floor_translation = 0.005;
  double floor_rotation = 0.003;
  RegistrationSettings registration = registration_defaults();

  static RegistrationSettings registration_defaults();

  void describe(SettingsVisitor& s) {
    s.number("indexed_features", indexed_features, "", {10, 10000},
             "strongest of each keyframe by which it can be found again");
    s.number("max_descriptor_distance", max_descriptor_distance, "", {0, 2},
             "between descriptors of unit norm; nearer ones vote");
    s.number("min_votes", min_votes, "", {1, 10000}, "that make a keyframe a loop candidate");
    s.number("candidates", candidates, "", {0, 100}, "most voted keyframes that are verified");
    s.number("min_inliers", min_inliers, "", {3, 1000}, "of RANSAC over the matched features");
    s.number("min_overlap", min_overlap, "", {0, 1}, "of the clouds, after ICP");
    s.number("min_inlier_share", min_inlier_share, "", {0, 1}, "of the pairs, within three sigmas");
    s.number("max_disagreement", max_disagreement, "", {0, 1e6},
             "Mahalanobis distance between what ICP and what the features say");
    s.number("floor_translation", floor_translation, "m", {0, 1000},
             "noise floor of an edge, added (squared): what a sensor's points of one view err alike");
    s.number("floor_rotation", floor_rotation, "rad", {0, 3.1416}, "noise floor of an edge, added (squared)");
    s.section("registration", registration, "of the two keyframes' clouds");
  }
};

/// What is seen from a keyframe; camera frame.
struct KeyframeView {
  int node = 0;            ///< when it is added
  Cloud cloud;             ///< reduced, with normals and sigmas
  double noise_left = 1;   ///< share of the sigmas that smoothing has left
  FeatureFrame features;   ///< may be empty
  std::vector<int> shows;  ///< keyframes that own the surfaces it lies on, of the most points first
};

std::size_t memory_bytes(const KeyframeView& view);

class LoopFinder {
 public:
  explicit LoopFinder(const LoopFinderSettings& settings);

  /// A keyframe that can be found again.
  void add(std::shared_ptr<const KeyframeView> view);
  const KeyframeView* view(int node) const;

  /// Loop candidates: nodes that most features vote for, most voted first; `without`: nodes that are known to
  /// be near.
  std::vector<int> candidates(const FeatureFrame& features, const std::vector<int>& without);

  /// Nodes that go (true), and the new numbers of the others; the index is made anew when it is used next.
  void renumber(const std::vector<bool>& gone, const std::vector<int>& number);
  std::size_t memory_bytes() const;

  /// T_from_to by geometry; nothing when it does not hold. `guess` is tried when features give no transform.
  std::optional<UncertainTransform> verify(const KeyframeView& from, const KeyframeView& to,
                                           const std::optional<Eigen::Isometry3d>& guess);

 private:
  void enter(const FeatureFrame& features, int node);
  void refresh_index();

  LoopFinderSettings settings_;
  std::vector<std::shared_ptr<const KeyframeView>> views_;  // by node, null where there is none
  DescriptorIndex index_;
  bool stale_ = false;  // index_ names nodes by old numbers
  std::vector<int> node_of_descriptor_;
  DescriptorSearch search_;
  Matcher matcher_;
};

}  // namespace lcmslam
