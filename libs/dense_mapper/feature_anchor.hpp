#pragma once
// Where the SURF features of a frame place the robot, against those of the keyframes around: knowledge for
// directions in which geometry alone slides (a wall, the ground), and without the drift of frame-to-frame
// odometry.

#include <optional>
#include <vector>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/features/matching.hpp>
#include <lcmslam/features/rigid_ransac.hpp>
#include <lcmslam/registration/solver.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct FeatureAnchorSettings {
  bool enabled = true;
  int keyframes = 2;
  double max_distance = 1.0;
  double max_angle = 0.7;
  int min_inliers = 20;
  int searched_keyframes = 5;
  double floor_translation = 0.005;
  double floor_rotation = 0.003;
  double recognised_share = 0.75;
  double max_disagreement = 5;
  double expected_within = 0.2;
  double wait = 0.1;

  void describe(SettingsVisitor& s) {
    s.flag("enabled", enabled, "features place the robot against the keyframes around");
    s.number("keyframes", keyframes, "", {1, 20}, "nearest ones that are asked");
    s.number("max_distance", max_distance, "m", {0, 1000},
             "between a keyframe's camera and this one's, beyond which SURF does not find things again");
    s.number("max_angle", max_angle, "rad", {0, 3.1416},
             "between a keyframe's camera and this one's, beyond which SURF does not find things again");
    s.number("min_inliers", min_inliers, "", {3, 1000}, "matches that must agree on a place");
    s.number("searched_keyframes", searched_keyframes, "", {0, 1000}, "asked in each frame while lost");
    s.number(
        "recognised_share", recognised_share, "", {0, 1},
        "of the matches that must agree on a place after a gap: things that look alike agree on one, too, "
        "but what stands around them does not");
    s.number("floor_translation", floor_translation, "m", {0, 1000},
             "noise floor of the alignment, added (squared): errors that all of a frame's features share");
    s.number("floor_rotation", floor_rotation, "rad", {0, 3.1416},
             "noise floor of the alignment, added (squared)");
    s.number("max_disagreement", max_disagreement, "", {0, 1e6},
             "Mahalanobis distance from odometry, beyond which the map judges");
    s.number(
        "expected_within", expected_within, "m", {0, 1000},
        "of where it is expected, a match is asked first, and all others only where too few of these agree: "
        "tiles and doors look alike at the next place, too");
    s.number("wait", wait, "s", {0, 60},
             "that a frame waits for its features where they come at all; then it goes on without them");
  }
};

/// Mahalanobis distance between two places.
double disagreement(const Prior& a, const Prior& b);

class FeatureAnchor {
 public:
  explicit FeatureAnchor(const FeatureAnchorSettings& settings);

  /// A keyframe's features and where its camera stood; `node` of the graph that it moves with.
  void add(const Eigen::Isometry3d& T_world_camera, const FeatureFrame& features, int node = 0);
  /// Keyframes move, each by T_new_old[node], those of later nodes by the last.
  void deform(const std::vector<Eigen::Isometry3d>& T_new_old);
  /// Keyframes of nodes that go (true), and the new numbers of the others.
  void renumber(const std::vector<bool>& gone, const std::vector<int>& number);
  void clear() { keyframes_.clear(); }
  std::size_t memory_bytes() const;

  /// Where the robot is, wherever that be: each call asks the next few keyframes. For a robot that is lost.
  std::optional<Prior> search(const FeatureFrame& features, const Eigen::Isometry3d& T_robot_camera);

  /// T_world_robot with its information, by the matches with all keyframes around T_world_camera (where the
  /// camera should be) together. What is seen elsewhere than expected must be recognised; nothing when too
  /// few agree.
  std::optional<Prior> locate(const FeatureFrame& features, const Eigen::Isometry3d& T_world_camera,
                              const Eigen::Isometry3d& T_robot_camera);

  /// The same for a robot that may be anywhere: twice the matches must agree, and the most of all.
  std::optional<Prior> recognise(const FeatureFrame& features, const Eigen::Isometry3d& T_world_camera,
                                 const Eigen::Isometry3d& T_robot_camera);

  /// Whether a view from there could be recognised at all: it has features enough, and so have keyframes
  /// around (or none stand there, which is an answer).
  bool can_recognise(const FeatureFrame& features, const Eigen::Isometry3d& T_world_camera) const;

 private:
  struct Keyframe {
    Eigen::Isometry3d T_world_camera;
    FeatureFrame features;
    int node = 0;
  };
  bool is_rich(const FeatureFrame& features) const;
  /// What features of keyframes (point_a, in the world) and of this frame (point_b, in its camera) match.
  std::vector<PointPair> matches(const std::vector<const Keyframe*>& keyframes, const FeatureFrame& features);
  std::optional<Prior> agreed(const std::vector<PointPair>& pairs, const Eigen::Isometry3d& T_robot_camera,
                              int min_inliers, double min_share = 0) const;
  std::vector<const Keyframe*> around(const Eigen::Isometry3d& T_world_camera) const;

  FeatureAnchorSettings settings_;
  std::vector<Keyframe> keyframes_;
  std::size_t next_search_ = 0;
  Matcher matcher_;
};

/// Both pieces of knowledge together: the minimum of the sum of both squared Mahalanobis distances.
Prior fused(const Prior& a, const Prior& b);

}  // namespace lcmslam
