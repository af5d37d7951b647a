// What the map server hears of mappers and cameras, and asks for again when it missed something.

#include <fmt/format.h>
#include <algorithm>
#include <set>

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include "procs/map-server/map_server_node.hpp"

namespace lcmslam {
namespace {

constexpr Utime resend_period =
    2'000'000;  // us of message time between two requests, twice as long each time
constexpr Utime longest_resend_period = 60'000'000;
constexpr Utime longest_behind = 1'000'000;  // us that a map may be older than its mapper's poses say

template <class M>
SessionKey key_of(const M& message) {
  return {message.sender, message.frame};
}

/// For what a message says that cannot be, or that there is no room for: it is counted, and STATUS tells it.
[[noreturn]] void refuse(const std::string& why) {
  throw DecodeError(why);
}

/// Null: it is not the mapper that is alive, as one is for a moment that has just restarted. What it makes by
/// then is asked for again (follow()).
template <class Map, class M>
auto* session_of(SessionTable<Map>& sessions, const M& message) {
  auto* session = sessions.session(key_of(message));
  if (session == nullptr && !sessions.is_stranger(key_of(message)))
    refuse(fmt::format("sender {} begins a map, and max_sessions are there", message.sender));
  return session;
}

/// Keyframes of the map that stay when the message has been followed.
std::size_t kept_by(const graph_t& message, const DenseMap& map) {
  const auto& keyframes = map.keyframes();
  std::set<std::int32_t> named;
  const auto name = [&](std::int32_t id) {
    if (keyframes.count(id) > 0) named.insert(id);
  };
  std::int32_t newest_node = -1;
  for (const graph_node_t& node : message.nodes) {
    name(node.keyframe);
    newest_node = std::max(newest_node, node.keyframe);
  }
  for (const auto& [id, keyframe] : keyframes)
    if (was_made_after(message, newest_node, id, keyframe.utime)) named.insert(id);
  if (message.change == 0) return named.size();
  named.clear();
  for (const std::int32_t id : message.gone) name(id);
  return keyframes.size() - named.size();
}

/// Of its graph, and of keyframes that were made after that was told.
std::map<std::int32_t, Eigen::Isometry3d> poses_of(const SessionTable<DenseMap>::Session& session) {
  std::map<std::int32_t, Eigen::Isometry3d> poses;
  for (const auto& [id, keyframe] : session.map.keyframes()) poses[id] = keyframe.T_world_camera;
  for (const KeyframePose& node : session.graph.poses()) poses[node.id] = node.T_world_camera;
  return poses;
}

bool is_whole(const FollowedGraph& graph) {
  return graph.complete() && !graph.nodes().empty();
}

bool is_whole(const LandmarkMap& map) {
  return !map.incomplete() && map.revision() > 0;
}

/// As its mapper would tell it.
graph_t whole_of(const FollowedGraph& graph) {
  graph_t message{};
  for (const auto& [id, node] : graph.nodes()) message.nodes.push_back(node);
  message.n_nodes = static_cast<std::int32_t>(message.nodes.size());
  return message;
}

}  // namespace

void MapServerNode::on_fastslam_pose(const pose_estimate_t& message) {
  hear_fastslam(key_of(message));
  add_to_path(fastslam_path_, message);
  fastslam_pose_ = message;
  if (recorder_) recorder_->pose("fastslam", key_of(message), message);
  const auto* session = landmark_maps_.find(key_of(message));
  const bool complete = session != nullptr && !session->map.incomplete();
  follow("fastslam", message, complete ? session->map.revision() : 0);
}

void MapServerNode::hear_fastslam(const SessionKey& key) {
  const std::size_t last = landmark_maps_.empty() ? 0 : landmark_maps_.current();
  if (!landmark_maps_.hear(key)) return;
  fastslam_path_.clear();
  if (!landmark_places_) return;
  const bool was_another = !landmark_maps_.empty() && !(landmark_maps_.all()[last].key == key);
  landmark_places_->begin_session(recorder_ ? recorder_->stored("fastslam", key) : 0,
                                  was_another ? landmark_maps_.all()[last].map : LandmarkMap());
}

void MapServerNode::on_icp_pose(const pose_estimate_t& message) {
  if (dense_maps_.hear(key_of(message))) {
    icp_path_.clear();
    begin_layers(key_of(message));
    begin_places(key_of(message));
  }
  add_to_path(icp_path_, message);
  T_map_robot_ = from_message(message.T_map_robot, "T_map_robot");
  icp_pose_ = message;
  if (layers_) show_frame(message);
  if (recorder_) recorder_->pose("icp", key_of(message), message);
  const auto* session = dense_maps_.find(key_of(message));
  if (session == nullptr) return follow("icp", message, 0);
  if (!session->graph.complete()) return follow("icp", message, 0);
  // The pose counts all keyframes that were made, the graph those that are kept.
  const std::int64_t kept = session->graph.map_revision();
  const std::int64_t given_up = kept > 0 ? std::max<std::int64_t>(0, message.map_revision - kept) : 0;
  follow("icp", message, static_cast<std::int64_t>(session->map.keyframes().size()) + given_up);
}

/// Who steps close before the robot hides the map, and its pose is DEGRADED: he stands in the way all the
/// same.
void MapServerNode::show_frame(const pose_estimate_t& message) {
  if (message.status == pose_estimate_t::TRACKING)
    layers_->pose(message.utime, *T_map_robot_);
  else if (message.status == pose_estimate_t::DEGRADED || message.status == pose_estimate_t::RELOCALISED)
    layers_->poor_pose(message.utime, *T_map_robot_);
}

void MapServerNode::add_to_path(Path& path, const pose_estimate_t& message) const {
  path.push_back(from_message(message.T_map_robot, "T_map_robot").translation());
  if (path.size() <= max_path_) return;
  for (std::size_t i = 0; 2 * i < path.size(); ++i) path[i] = path[2 * i];
  path.resize((path.size() + 1) / 2);
}

void MapServerNode::on_landmarks(const landmarks_t& message) {
  const std::vector<Landmark> landmarks = landmarks_of(message);
  auto* const of_sender = session_of(landmark_maps_, message);
  if (of_sender == nullptr) return;
  LandmarkMap& map = of_sender->map;
  // A mapper takes away a few landmarks at a time. Who takes the most of a map away leaves it beside.
  const bool may_take_most = message.base_revision == 0 || 2 * message.removed.size() > map.size();
  std::optional<LandmarkMap> before;
  if (may_take_most && map.size() > 0) before = map;
  bool whole = message.base_revision == 0;
  try {
    if (whole && message.n_tiles > 1)
      whole = map.add_tile({message.map_revision, message.tile, message.n_tiles, landmarks});
    else
      map.apply({message.map_revision, message.base_revision, landmarks, message.removed});
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
  ++changes_;
  if (before && 2 * map.size() < before->size()) keep_beside(message, map, std::move(*before));
  const auto* session = landmark_maps_.find(key_of(message));
  if (recorder_) recorder_->landmarks(session->key, message, session->map, whole);
  if (landmark_places_ && session == &landmark_maps_.all()[landmark_maps_.current()])
    landmark_places_->follow(session->map);
}

/// Whether the map's mapper is the one that is told and derived from.
bool MapServerNode::is_current(const SessionKey& key) const {
  return !dense_maps_.empty() && dense_maps_.all()[dense_maps_.current()].key == key;
}

void MapServerNode::on_calibration(const camera_calibration_t& message) {
  if (recorder_) recorder_->calibration(message);
  if (!layers_) return;
  if (layers_->calibration()) {
    if (is_of_another_camera(message.sender, calibration_message_.sender, *stamps_)) return;
    if (same_calibration(message, calibration_message_)) return;
  }
  layers_->calibrate(from_message(message));
  calibration_message_ = message;
  stored_calibration_ = std::make_shared<StoredCalibration>(stored(message));
}

void MapServerNode::on_camera(const images_t& message) {
  if (auto picture = picture_alone(message)) {  // over a bridge, for who watches; nothing is made of it
    picture_ = std::make_shared<const EncodedFrame>(std::move(*picture));
    return;
  }
  if (layers_->calibration()) layers_->camera(checked_images(message, *layers_->calibration()));
}

/// A message took the most of a map away: it stays beside as it was `before`, or else in its place.
void MapServerNode::keep_beside(const landmarks_t& message, LandmarkMap& map, LandmarkMap before) {
  if (!landmark_maps_.keep_beside(key_of(message), before)) {
    map = std::move(before);
    refuse("it takes away the most of a map, and there is no room to keep that beside");
  }
  const auto& kept = landmark_maps_.all().back();
  if (recorder_) recorder_->kept_beside(kept.key, kept.map);
}

void MapServerNode::on_keyframe(const keyframe_t& message) {
  const KeyframeTile tile = from_message(message);
  auto* const session = session_of(dense_maps_, message);
  if (session == nullptr) return;
  DenseMap& map = session->map;
  bool complete = false;
  try {
    complete = map.add(tile);
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
  ++changes_;
  if (!complete) return;
  const DenseKeyframe& keyframe = map.keyframes().at(tile.part.id);
  if (recorder_) recorder_->keyframe(key_of(message), keyframe);
  if (const auto found = keyframe_features_.keyframe({key_of(message), keyframe.id, keyframe.utime}))
    remember(*found);
  if (layers_ && is_current(key_of(message))) derive_from(key_of(message), keyframe);
}

void MapServerNode::on_features(const features_t& message) {
  for (const KeyframeFeatures::Found& found : keyframe_features_.features(message)) remember(found);
}

/// A keyframe has its features.
void MapServerNode::remember(const KeyframeFeatures::Found& found) {
  const auto& [key, id, utime] = found.keyframe;
  if (recorder_) recorder_->features(key, id, found.features);
  const auto* session = dense_maps_.find(key);
  if (!places_ || !is_current(key) || session == nullptr) return;
  const auto keyframe = session->map.keyframes().find(id);
  if (keyframe != session->map.keyframes().end())
    places_->keyframe(id, keyframe->second.T_world_camera, found.features, keyframe->second.cloud);
}

/// Keyframes may have come before the first pose of their map.
void MapServerNode::begin_layers(const SessionKey& key) {
  if (!layers_) return;
  layers_->begin_map();
  late_.clear();
  if (const auto* session = dense_maps_.find(key))
    for (const auto& [id, keyframe] : session->map.keyframes()) late_.insert(id);
}

void MapServerNode::begin_places(const SessionKey& key) {
  if (!places_) return;
  places_->begin_session(recorder_ ? recorder_->stored("icp", key) : 0);
  // A server that begins anew may hear the whole graph before it knows whose poses count.
  const auto* session = dense_maps_.find(key);
  if (session != nullptr && session->graph.complete()) places_->follow(poses_of(*session));
}

void MapServerNode::derive_from(const SessionKey& key, const DenseKeyframe& keyframe) {
  if (!layers_->has_time_for(keyframe)) {
    late_.insert(keyframe.id);
    return;
  }
  auto images = layers_->keyframe(
      keyframe, [&] { return recorder_ ? recorder_->kept_images(key, keyframe.id) : std::nullopt; });
  if (images) images->calibration = stored_calibration_;
  if (recorder_ && images) recorder_->images(key, keyframe.id, std::move(*images));
}

void MapServerNode::on_graph(const graph_t& message) {
  from_message(message);  // throws before anything is kept beside
  auto* session = session_of(dense_maps_, message);
  if (session == nullptr) return;
  const bool takes_most = 2 * kept_by(message, session->map) < session->map.keyframes().size();
  if (takes_most) {
    if (!dense_maps_.keep_beside(key_of(message), session->map))
      refuse("it takes away the most of a map, and there is no room to keep that beside");
    const auto& kept = dense_maps_.all().back();
    if (recorder_) recorder_->kept_beside(kept.key, kept.map, key_of(message));
  }
  session = dense_maps_.find(key_of(message));
  session->graph.apply(message);
  lcmslam::follow(session->map, session->graph, message);
  ++changes_;
  const std::int64_t stored = recorder_ ? recorder_->stored("icp", session->key) : 0;
  if (recorder_) recorder_->graph(session->key, message, session->graph, session->map);
  if (!is_current(session->key)) return;
  if (layers_) layers_->correct(session->map, session->graph);
  if (!places_) return;
  if (stored != 0 && recorder_->stored("icp", session->key) == 0) places_->leave_stored();
  correct_places(message, *session, takes_most);
}

/// Places, too, are not taken away by one message.
void MapServerNode::correct_places(const graph_t& message, const SessionTable<DenseMap>::Session& session,
                                   bool takes_most) {
  if (message.change == 0) return places_->follow(poses_of(session));
  std::map<std::int32_t, Eigen::Isometry3d> moved;  // by the graph: a restarted server has no keyframes yet
  const auto& nodes = session.graph.nodes();
  for (const graph_node_t& told : message.nodes)
    if (const auto node = nodes.find(told.keyframe); node != nodes.end())
      moved[node->first] = from_message(node->second.T_map_camera, "T_map_camera");
  std::vector<std::int32_t> gone;
  for (const std::int32_t id : message.gone)
    if (!takes_most && session.map.keyframes().count(id) == 0) gone.push_back(id);
  places_->correct(moved, gone);
}

/// Mappers that lived on while this server restarted and the file was held: that has the begin of their
/// sessions.
void MapServerNode::go_on_with_stored() {
  for (const auto& session : landmark_maps_.all())
    if (recorder_->goes_on("fastslam", session.key) != 0 && is_whole(session.map))
      recorder_->landmarks(session.key, {}, session.map, true);
  for (const auto& session : dense_maps_.all())
    if (recorder_->goes_on("icp", session.key) != 0 && is_whole(session.graph))
      recorder_->graph(session.key, whole_of(session.graph), session.graph, session.map);
  if (!places_) return;
  if (fastslam_pose_) landmark_places_->go_on_as(recorder_->goes_on("fastslam", key_of(*fastslam_pose_)));
  if (!icp_pose_) return;
  places_->go_on_as(recorder_->goes_on("icp", key_of(*icp_pose_)));
  const auto* session = dense_maps_.find(key_of(*icp_pose_));
  if (session != nullptr && is_whole(session->graph)) places_->follow(poses_of(*session));
}

/// What is in memory, as its mappers told it.
void MapServerNode::record_all() {
  for (const auto& session : landmark_maps_.all()) recorder_->landmarks(session.key, {}, session.map, true);
  for (const auto& session : dense_maps_.all()) {
    for (const auto& [id, keyframe] : session.map.keyframes()) recorder_->keyframe(session.key, keyframe);
    recorder_->graph(session.key, whole_of(session.graph), session.graph, session.map);
  }
}

// A map to which something does not come that its mapper's poses named a while ago has lost it: this server
// restarted, or a message did not arrive. One that comes late all the time (over a bridge) has not.
void MapServerNode::follow(const std::string& process, const pose_estimate_t& pose, std::int64_t revision) {
  Progress& progress = progress_[process];
  const bool watched = progress.since != 0 && pose.utime >= progress.since;
  if (!watched || revision >= std::min(progress.wanted, pose.map_revision)) {
    progress.wanted = pose.map_revision;
    progress.since = pose.utime;
  }
  if (!watched || revision >= pose.map_revision) progress.pause = resend_period;
  if (pose.utime < progress.asked) progress.asked = 0;
  if (pose.utime - progress.since < longest_behind || pose.utime - progress.asked < progress.pause) return;
  if (progress.asked != 0) progress.pause = std::min(2 * progress.pause, longest_resend_period);
  progress.asked = pose.utime;
  ++resends_;
  command_t command;
  command.utime = pose.utime;
  command.target = process;
  command.name = "resend";
  command.n = 0;
  publisher_.publish("COMMAND", command);
}

}  // namespace lcmslam
