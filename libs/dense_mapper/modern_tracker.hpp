#pragma once
// The tracker that is the best we know. Features of keyframes place the robot beside odometry, and where both
// tell different places the map judges. Registration begins at several places when the robot may be lost, the
// best-looking first; each start takes a coarse pass over few points and a fine one.

#include <optional>
#include <vector>

#include <lcmslam/dense_mapper/deformable_map.hpp>
#include <lcmslam/dense_mapper/keyframe_store.hpp>
#include <lcmslam/dense_mapper/last_view.hpp>
#include <lcmslam/dense_mapper/registration_passes.hpp>
#include <lcmslam/dense_mapper/tracker.hpp>

namespace lcmslam {

class ModernTracker : public Tracker {
 public:
  ModernTracker(const DenseMapperSettings& settings, DeformableMap& map, const KeyframeStore& keyframes);

  Tracked track(const PreparedFrame& prepared, const Expectation& expected) override;
  void accept(const PreparedFrame& prepared, const Eigen::Isometry3d& T_world_robot,
              bool registered) override;
  bool searches_map() const override { return true; }
  void add_keyframe(const FeatureFrame& features, const Eigen::Isometry3d& T_world_camera, int node) override;
  void deform(const KeyframeGraph::Correction& correction) override;
  void renumber(const KeyframeGraph::Thinned& thinned) override;
  std::size_t memory_bytes() const override { return anchor_.memory_bytes(); }

 private:
  Tracked on_floor(const PreparedFrame& prepared, const Expectation& expected);
  Tracked led(const PreparedFrame& prepared, const Expectation& expected);
  std::optional<Tracked> as_pushed(const PreparedFrame& prepared, const Expectation& expected);
  Tracked by_what_stands(const PreparedFrame& standing, Expectation expected);
  bool is_elsewhere(const Tracked& tracked, const DenseFrame& frame, const Expectation& expected) const;
  Tracked place(const PreparedFrame& prepared, const Prior& prior, const Expectation& expected);
  std::optional<Prior> ask_features(const PreparedFrame& prepared, Tracked& result);
  Prior judged_by_map(const PreparedFrame& prepared, const Prior& odometry, const Prior& anchor);
  std::vector<Eigen::Isometry3d> starts(const DenseFrame& frame, const Prior& prior,
                                        const std::optional<Prior>& anchor, const Expectation& expected);
  void confirm(const DenseFrame& frame, Tracked& result);
  void recognise(const DenseFrame& frame, Tracked& result);
  bool can_recognise(const DenseFrame& frame, const Tracked& result) const;
  bool is_certain(const DenseFrame& frame, const RegistrationResult& placed) const;
  double score(const Cloud& cloud, const Eigen::Isometry3d& T_world_robot) const;
  void sort_by_score(const Cloud& cloud, std::vector<Eigen::Isometry3d>& starts) const;
  RegistrationPasses::Attempt try_starts(const PreparedFrame& prepared, std::vector<Eigen::Isometry3d> starts,
                                         const Prior& prior, bool adrift);

  DenseMapperSettings settings_;
  DeformableMap& map_;
  const KeyframeStore& keyframes_;
  MapTarget view_;  // of the map
  RegistrationPasses passes_;
  FeatureAnchor anchor_;
  LastView last_view_;
  std::size_t next_recovery_ = 0;  // keyframe to try next while lost
};

}  // namespace lcmslam
