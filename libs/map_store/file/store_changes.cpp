#include <lcmslam/map_store/file/store_changes.hpp>

namespace lcmslam {
namespace {

template <class Value>
void take_over(std::optional<Value>& value, std::optional<Value>& newer) {
  if (newer) value = std::move(newer);
}

}  // namespace

void SessionChanges::put_keyframe(const DenseKeyframe& keyframe, const std::optional<Matrix6d>& covariance) {
  KeyframeChange& change = keyframes_[keyframe.id];
  change.utime = keyframe.utime;
  change.T_map_camera = keyframe.T_world_camera;
  if (covariance) change.covariance = covariance;
  change.cloud = keyframe.cloud;
}

void SessionChanges::put_features(std::int32_t keyframe, const FeatureFrame& features) {
  keyframes_[keyframe].features = features;
}

void SessionChanges::put_images(std::int32_t keyframe, StoredImages images) {
  keyframes_[keyframe].images = std::move(images);
}

void SessionChanges::share(const SessionChanges& other, const std::vector<std::int32_t>& keyframes) {
  for (const std::int32_t id : keyframes) {
    const auto known = other.keyframes_.find(id);
    if (known == other.keyframes_.end()) continue;
    if (known->second.features) keyframes_[id].features = known->second.features;
    if (known->second.images) keyframes_[id].images = known->second.images;
    if (known->second.covariance) keyframes_[id].covariance = known->second.covariance;
  }
}

void SessionChanges::move_keyframe(std::int32_t keyframe, Utime utime, const Eigen::Isometry3d& T_map_camera,
                                   const std::optional<Matrix6d>& covariance) {
  KeyframeChange& change = keyframes_[keyframe];
  change.utime = utime;
  change.T_map_camera = T_map_camera;
  if (covariance) change.covariance = covariance;
}

void SessionChanges::drop_keyframe(std::int32_t keyframe) {
  cut_edges_of(keyframe);
  keyframes_[keyframe] = {};
  keyframes_[keyframe].dropped = true;
}

void SessionChanges::cut_edges_of(std::int32_t keyframe) {
  for (auto edge = edges_.begin(); edge != edges_.end();)
    edge = edge->first.first == keyframe || edge->first.second == keyframe ? edges_.erase(edge)
                                                                           : std::next(edge);
}

void SessionChanges::set_edges(const Pair& pair, std::vector<StoredEdge> edges) {
  edges_[pair] = std::move(edges);
}

void SessionChanges::clear_edges() {
  edges_cleared_ = true;
  edges_.clear();
}

void SessionChanges::clear_landmarks() {
  landmarks_cleared_ = true;
  landmarks_.clear();
}

void SessionChanges::append_pose(const StoredPose& pose) {
  trajectory_.push_back(pose);
  if (trajectory_.size() <= most_poses) return;
  for (std::size_t i = 0; 2 * i < trajectory_.size(); ++i) trajectory_[i] = trajectory_[2 * i];
  trajectory_.resize((trajectory_.size() + 1) / 2);
}

void SessionChanges::follow(SessionChanges&& newer) {
  for (auto& [id, change] : newer.keyframes_) {
    if (change.dropped) drop_keyframe(id);
    KeyframeChange& mine = keyframes_[id];
    take_over(mine.utime, change.utime);
    take_over(mine.T_map_camera, change.T_map_camera);
    take_over(mine.covariance, change.covariance);
    take_over(mine.cloud, change.cloud);
    take_over(mine.features, change.features);
    take_over(mine.images, change.images);
  }
  if (newer.edges_cleared_) clear_edges();
  for (auto& [pair, edges] : newer.edges_) edges_[pair] = std::move(edges);
  if (newer.landmarks_cleared_) clear_landmarks();
  for (auto& [id, landmark] : newer.landmarks_) landmarks_[id] = std::move(landmark);
  for (const StoredPose& pose : newer.trajectory_) append_pose(pose);
}

bool SessionChanges::empty() const {
  return keyframes_.empty() && !edges_cleared_ && edges_.empty() && !landmarks_cleared_ &&
         landmarks_.empty() && trajectory_.empty();
}

}  // namespace lcmslam
