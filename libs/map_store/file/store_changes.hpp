#pragma once
// What changed in a map since it was last written: of everything the newest state, so that what waits is
// never more than the map itself, however long the disk takes.

#include <map>
#include <utility>

#include <lcmslam/features/landmark.hpp>
#include <lcmslam/map_store/file/stored_map.hpp>

namespace lcmslam {

/// What is not set stays as it is in the file.
struct KeyframeChange {
  bool dropped = false;  ///< all that the file has of it goes; what is set here comes after that
  std::optional<Utime> utime;
  std::optional<Eigen::Isometry3d> T_map_camera;
  std::optional<Matrix6d> covariance;  ///< set with T_map_camera only
  std::optional<ColouredCloud> cloud;
  std::optional<FeatureFrame> features;
  std::optional<StoredImages> images;
};

/// Of one session.
class SessionChanges {
 public:
  using Pair = std::pair<std::int32_t, std::int32_t>;  ///< of keyframes, as edges name them
  static constexpr std::size_t most_poses = 200'000;   ///< that wait; then every second one goes

  void put_keyframe(const DenseKeyframe& keyframe, const std::optional<Matrix6d>& covariance);
  void put_features(std::int32_t keyframe, const FeatureFrame& features);
  void put_images(std::int32_t keyframe, StoredImages images);
  /// What waits of another session's features, images and covariances belongs to this one, too.
  void share(const SessionChanges& other, const std::vector<std::int32_t>& keyframes);
  void move_keyframe(std::int32_t keyframe, Utime utime, const Eigen::Isometry3d& T_map_camera,
                     const std::optional<Matrix6d>& covariance = std::nullopt);
  /// With its edges.
  void drop_keyframe(std::int32_t keyframe);
  /// All edges between the pair; none: there is none any more.
  void set_edges(const Pair& pair, std::vector<StoredEdge> edges);
  /// There are no edges but those that are set from now on.
  void clear_edges();
  void put_landmark(const Landmark& landmark) { landmarks_[landmark.id] = landmark; }
  void drop_landmark(std::int64_t id) { landmarks_[id].reset(); }
  /// There are no landmarks but those that are put from now on.
  void clear_landmarks();
  void append_pose(const StoredPose& pose);

  /// Lets `newer` follow on this.
  void follow(SessionChanges&& newer);
  bool empty() const;

  const std::map<std::int32_t, KeyframeChange>& keyframes() const { return keyframes_; }
  bool edges_cleared() const { return edges_cleared_; }
  const std::map<Pair, std::vector<StoredEdge>>& edges() const { return edges_; }
  bool landmarks_cleared() const { return landmarks_cleared_; }
  /// By id; without value: dropped.
  const std::map<std::int64_t, std::optional<Landmark>>& landmarks() const { return landmarks_; }
  const std::vector<StoredPose>& trajectory() const { return trajectory_; }

 private:
  void cut_edges_of(std::int32_t keyframe);

  std::map<std::int32_t, KeyframeChange> keyframes_;
  bool edges_cleared_ = false, landmarks_cleared_ = false;
  std::map<Pair, std::vector<StoredEdge>> edges_;
  std::map<std::int64_t, std::optional<Landmark>> landmarks_;
  std::vector<StoredPose> trajectory_;
};

}  // namespace lcmslam
