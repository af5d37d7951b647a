#include "procs/map-server/map_recorder.hpp"

#include <spdlog/spdlog.h>
#include <algorithm>
#include <cstdlib>
#include <iterator>

#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/runtime/version.hpp>

namespace lcmslam {
namespace {

constexpr Utime half_frame = 17'000;      // us, at 30 Hz
constexpr std::size_t most_recent = 100;  // poses
constexpr std::size_t most_sensors = 16;
constexpr std::chrono::seconds retry_period(1);

StoredEdge stored(const graph_edge_t& edge) {
  return {edge.from_node,   edge.to_node,   edge.kind, from_message(edge.T_from_to, "T_from_to"),
          edge.sigma_trans, edge.sigma_rot, edge.error};
}

/// Without those that cannot be.
std::vector<StoredEdge> edges_between(const FollowedGraph& graph, const FollowedGraph::Pair& pair) {
  std::vector<StoredEdge> edges;
  const auto [begin, end] = graph.edges().equal_range(pair);
  for (auto edge = begin; edge != end; ++edge) try {
      edges.push_back(stored(edge->second));
    } catch (const DecodeError&) {
    }
  return edges;
}

StoredSession placed(const Joint& joint) {
  StoredSession place;
  place.state = SessionState::joined;
  place.T_map_session = joint.T_map_session;
  place.evidence = to_string(joint);
  return place;
}

template <class Item>
void push_bounded(std::deque<Item>& items, Item item, std::size_t most) {
  items.push_back(std::move(item));
  if (items.size() > most) items.pop_front();
}

}  // namespace

MapRecorder::MapRecorder(const std::filesystem::path& file, const std::string& configuration)
    : file_(file), writer_(file, {lcmslam_version, configuration}) {
  read_kept(Database::usual_patience);
}

void MapRecorder::read_kept(std::chrono::milliseconds patience) {
  unreadable_.clear();
  may_be_read_later_ = false;
  damage_.clear();
  if (may_be_there(file_)) try {
      MapFile map(file_, patience);
      for (const StoredSession& session : map.sessions(&damage_)) try {
          newest_of_before_ = session.id;
          keep(map, session, &damage_);
        } catch (const StoreError& error) {
          damage_.push_back(error.what());
          number(session);
        }
      spdlog::info("{}: goes on, with {} sessions of earlier runs", file_.string(), kept_.size());
      go_on_with_stored();
    } catch (const PassingStoreError& error) {
      unreadable_ = error.what();
      may_be_read_later_ = true;
    } catch (const std::exception& error) {
      unreadable_ = error.what();
    }
  // What this run has begun must not be taken for what an earlier one has left.
  writer_.hold(may_be_read_later_ ? unreadable_ : "");
}

bool MapRecorder::read_again(std::chrono::milliseconds patience) {
  if (!may_be_read_later_) return false;
  read_kept(patience);
  return is_read();
}

/// Nothing of these is in the file yet, as it was held.
void MapRecorder::go_on_with_stored() {
  for (auto& [name, session] : sessions_) {
    if (session.is_beside) continue;
    const auto& [mapper, sender_and_frame] = name;
    const std::int64_t id = take_up(mapper, {sender_and_frame.first, sender_and_frame.second}, session);
    if (id != 0) writer_.go_on(session.number, id);
  }
}

/// Its name, by which place it has among all.
std::string MapRecorder::number(const StoredSession& session) {
  auto place = std::find_if(stored_.begin(), stored_.end(),
                            [&](const StoredSession& other) { return other.id >= session.id; });
  if (place != stored_.end() && place->id == session.id)
    *place = session;
  else
    place = stored_.insert(place, session);
  return names_of(stored_)[static_cast<std::size_t>(place - stored_.begin())];
}

/// Of what it has, the numbers alone are kept here. Where that cannot be read it is none of those.
void MapRecorder::keep(MapFile& map, const StoredSession& session, MapFile::Damage* damage) {
  const auto frame = map.frame_session(session.mapper);
  const std::vector<StoredKeyframe> keyframes = map.keyframes(session.id, damage);
  const SessionCounts counts = map.counts(session.id);

  if (frame) frame_sessions_[session.mapper] = *frame;
  KeptSession kept{session.id, session.mapper, number(session)};
  std::map<std::int32_t, Utime>& times = stored_keyframes_[session.id] = {};
  for (const StoredKeyframe& keyframe : keyframes) {
    times[keyframe.id] = keyframe.utime;
    kept.begin = kept.begin == 0 ? keyframe.utime : std::min(kept.begin, keyframe.utime);
    kept.end = std::max(kept.end, keyframe.utime);
  }
  kept.keyframes = counts.clouds;
  kept.landmarks = counts.landmarks;
  if (kept.keyframes + kept.landmarks == 0) return;
  const auto later =
      std::find_if(kept_.begin(), kept_.end(), [&](const KeptSession& other) { return other.id > kept.id; });
  kept_.insert(later, kept);
}

std::optional<std::int64_t> MapRecorder::retire(const std::string& mapper, const SessionKey& key) {
  const auto session = sessions_.find({mapper, {key.sender, key.frame}});
  if (session == sessions_.end() || std::chrono::steady_clock::now() < next_retiring_) return std::nullopt;
  const auto id = writer_.written(session->second.number);
  if (!id) return std::nullopt;
  try {
    MapFile map(file_);
    MapFile::Damage of_other_places;
    for (const StoredSession& stored : map.sessions(&of_other_places))
      if (stored.id == *id) keep(map, stored, nullptr);
  } catch (const StoreError&) {  // it stays in memory, whose keyframes are whole
    next_retiring_ = std::chrono::steady_clock::now() + retry_period;
    return std::nullopt;
  }
  sessions_.erase(session);
  return id;
}

std::size_t MapRecorder::kept(const std::string& mapper) const {
  return static_cast<std::size_t>(
      std::count_if(stored_.begin(), stored_.end(),
                    [&](const StoredSession& session) { return session.mapper == mapper; }));
}

std::string MapRecorder::error() const {
  const std::string failure = writer_.state().error;
  return failure.empty() ? unreadable_ : failure;
}

std::string MapRecorder::damage() const {
  if (damage_.size() < 2) return damage_.empty() ? "" : damage_.front();
  return damage_.front() + ", and " + std::to_string(damage_.size() - 1) + " more";
}

MapRecorder::Session& MapRecorder::session(const std::string& mapper, const SessionKey& key) {
  const auto [found, fresh] = sessions_.try_emplace({mapper, {key.sender, key.frame}});
  return fresh ? begin_session(mapper, key, found->second) : found->second;
}

/// A mapper that lived on while this server restarted goes on with its session.
MapRecorder::Session& MapRecorder::begin_session(const std::string& mapper, const SessionKey& key,
                                                 Session& session) {
  StoredSession begun{0, mapper, key.sender, key.frame};
  begun.id = take_up(mapper, key, session);
  session.number = writer_.begin_session(begun);
  return session;
}

/// Its id in the file; 0: that has none of this mapper and frame.
std::int64_t MapRecorder::take_up(const std::string& mapper, const SessionKey& key, Session& session) {
  std::int64_t id = 0;
  for (const StoredSession& old : stored_)
    if (old.mapper == mapper && old.sender == key.sender && old.frame == key.frame) id = old.id;
  if (id == 0) return 0;
  session.kept_id = id;
  const auto& stored = stored_keyframes_[id];
  session.keyframes.insert(stored.begin(), stored.end());
  for (const KeptSession& kept : kept_)
    if (kept.id == id) {
      session.unheard_landmarks = static_cast<std::size_t>(kept.landmarks);
      session.was_kept = kept;
    }
  kept_.erase(
      std::remove_if(kept_.begin(), kept_.end(), [&](const KeptSession& kept) { return kept.id == id; }),
      kept_.end());
  return id;
}

void MapRecorder::landmarks(const SessionKey& key, const landmarks_t& message, const LandmarkMap& map,
                            bool whole) {
  Session& s = session("fastslam", key);
  const std::size_t stay =
      whole ? map.size() : s.unheard_landmarks - std::min(s.unheard_landmarks, message.removed.size());
  if (2 * stay < s.unheard_landmarks) {
    leave_beside("fastslam", key, s);
    whole = true;
  }
  s.unheard_landmarks = whole ? 0 : stay;
  writer_.change(s.number, [&](SessionChanges& changes) {
    if (whole) {
      changes.clear_landmarks();
      for (const Landmark& landmark : map.landmarks()) changes.put_landmark(landmark);
      return;
    }
    // As the map has them now: it leaves out changes that come late, and parts of a map that is not whole.
    for (const landmark_t& told : message.landmarks)
      if (const Landmark* landmark = map.find(told.id)) changes.put_landmark(*landmark);
    for (const std::int64_t id : message.removed)
      if (map.find(id) == nullptr) changes.drop_landmark(id);
  });
}

void MapRecorder::keyframe(const SessionKey& key, const DenseKeyframe& keyframe) {
  put_keyframe(session("icp", key), keyframe);
}

void MapRecorder::put_keyframe(Session& s, const DenseKeyframe& keyframe) {
  s.keyframes[keyframe.id] = keyframe.utime;
  const auto covariance = covariance_at(keyframe.utime);
  writer_.change(s.number, [&](SessionChanges& changes) { changes.put_keyframe(keyframe, covariance); });
}

void MapRecorder::images(const SessionKey& key, std::int32_t keyframe, StoredImages images) {
  writer_.change(session("icp", key).number,
                 [&](SessionChanges& changes) { changes.put_images(keyframe, std::move(images)); });
}

std::optional<StoredImages> MapRecorder::kept_images(const SessionKey& key, std::int32_t keyframe) {
  const std::int64_t id = session("icp", key).kept_id;
  if (id == 0) return std::nullopt;
  try {
    return MapFile(file_).images(id, keyframe);
  } catch (const StoreError&) {
    return std::nullopt;
  }
}

void MapRecorder::graph(const SessionKey& key, const graph_t& message, const FollowedGraph& graph,
                        const DenseMap& map) {
  Session& s = session("icp", key);
  const bool whole = message.change == 0;
  const auto is_gone = [&](std::int32_t id) {
    return graph.nodes().count(id) == 0 && map.keyframes().count(id) == 0;
  };
  std::set<std::int32_t> gone;
  for (const std::int32_t id : message.gone)
    if (s.keyframes.count(id) > 0 && is_gone(id)) gone.insert(id);
  if (whole)
    for (const auto& [id, utime] : s.keyframes)
      if (is_gone(id) && !was_made_after(message, graph.newest_node(), id, utime)) gone.insert(id);
  if (s.kept_id != 0 && 2 * gone.size() > s.keyframes.size()) {
    const std::size_t before = s.number;
    leave_beside("icp", key, s);
    put_keyframes(s, map, before);
    gone.clear();
  }
  std::set<FollowedGraph::Pair> pairs;
  if (whole)
    for (const auto& [pair, edge] : graph.edges()) pairs.insert(pair);
  for (const graph_edge_t& edge : message.edges) pairs.insert({edge.from_node, edge.to_node});
  for (std::size_t i = 0; i < message.cut_from.size(); ++i)
    pairs.insert({message.cut_from[i], message.cut_to[i]});

  writer_.change(s.number, [&](SessionChanges& changes) {
    for (const std::int32_t id : gone) {
      changes.drop_keyframe(id);
      s.keyframes.erase(id);
    }
    for (const graph_node_t& told : message.nodes) {
      const auto node = graph.nodes().find(told.keyframe);
      if (node == graph.nodes().end()) continue;
      changes.move_keyframe(node->first, node->second.keyframe_utime,
                            from_message(node->second.T_map_camera, "T_map_camera"));
      s.keyframes[node->first] = node->second.keyframe_utime;
    }
    if (whole) changes.clear_edges();
    for (const auto& pair : pairs) changes.set_edges(pair, edges_between(graph, pair));
  });
}

/// What this server has not in memory would be lost: the file keeps it as it is.
void MapRecorder::leave_beside(const std::string& mapper, const SessionKey& key, Session& s) {
  if (s.was_kept) {
    const auto later = [&](const KeptSession& kept) { return kept.id > s.was_kept->id; };
    kept_.insert(std::find_if(kept_.begin(), kept_.end(), later), *s.was_kept);
  }
  s = {};
  s.is_beside = true;
  s.number = writer_.begin_session({0, mapper, key.sender, key.frame});
}

void MapRecorder::kept_beside(const SessionKey& key, const DenseMap& map, const SessionKey& of) {
  put_keyframes(new_session("icp", key), map, session("icp", of).number);
}

/// Of another map than one that an earlier server kept beside under this name.
MapRecorder::Session& MapRecorder::new_session(const std::string& mapper, const SessionKey& key) {
  Session& session = sessions_[{mapper, {key.sender, key.frame}}] = {};
  session.is_beside = true;
  session.number = writer_.begin_session({0, mapper, key.sender, key.frame});
  return session;
}

void MapRecorder::put_keyframes(Session& s, const DenseMap& map, std::size_t shared_with) {
  std::vector<std::int32_t> ids;
  for (const auto& [id, keyframe] : map.keyframes()) {
    put_keyframe(s, keyframe);
    ids.push_back(id);
  }
  writer_.share(shared_with, s.number, ids);
}

void MapRecorder::kept_beside(const SessionKey& key, const LandmarkMap& map) {
  writer_.change(new_session("fastslam", key).number, [&](SessionChanges& changes) {
    for (const Landmark& landmark : map.landmarks()) changes.put_landmark(landmark);
  });
}

void MapRecorder::pose(const std::string& mapper, const SessionKey& key, const pose_estimate_t& message) {
  const StoredPose pose{message.utime, from_message(message.T_map_robot, "T_map_robot")};
  writer_.change(session(mapper, key).number, [&](SessionChanges& changes) { changes.append_pose(pose); });
  if (mapper != "icp") return;
  try {
    push_bounded(covariances_, {message.utime, covariance_from_message(message.covariance, "covariance")},
                 most_recent);
  } catch (const DecodeError&) {  // then this pose has none
  }
}

std::optional<Matrix6d> MapRecorder::covariance_at(Utime utime) const {
  std::optional<Matrix6d> nearest;
  Utime distance = half_frame;
  for (const auto& [at, covariance] : covariances_) {
    if (std::abs(at - utime) > distance) continue;
    distance = std::abs(at - utime);
    nearest = covariance;
  }
  return nearest;
}

void MapRecorder::features(const SessionKey& key, std::int32_t keyframe, const FeatureFrame& features) {
  writer_.change(session("icp", key).number,
                 [&](SessionChanges& changes) { changes.put_features(keyframe, features); });
}

void MapRecorder::place(const std::string& mapper, const SessionKey& key, const Joint& joint) {
  writer_.place(session(mapper, key).number, placed(joint));
}

void MapRecorder::place(std::int64_t stored, const Joint& joint) {
  for (StoredSession& old : stored_) {
    if (old.id != stored) continue;
    writer_.place(writer_.begin_session(old), placed(joint));
    old.T_map_session = joint.T_map_session;
    old.evidence = to_string(joint);
  }
}

std::int64_t MapRecorder::goes_on(const std::string& mapper, const SessionKey& key) const {
  const auto known = sessions_.find({mapper, {key.sender, key.frame}});
  return known != sessions_.end() ? known->second.kept_id : 0;
}

std::optional<std::string> MapRecorder::evidence(std::int64_t stored) const {
  for (const StoredSession& old : stored_) {
    if (old.id != stored) continue;
    if (old.T_map_session) return old.evidence;
    const auto frame = frame_sessions_.find(old.mapper);
    if (frame != frame_sessions_.end() && frame->second == stored) return "";
  }
  return std::nullopt;
}

std::int64_t MapRecorder::stored(const std::string& mapper, const SessionKey& key) {
  return session(mapper, key).kept_id;
}

void MapRecorder::calibration(const camera_calibration_t& message) {
  const StoredCalibration told = lcmslam::stored(message);
  if (calibrations_.size() >= most_sensors && calibrations_.count(message.sensor) == 0) return;
  std::vector<std::uint8_t>& known = calibrations_[message.sensor];
  if (known == told.bytes) return;  // what says the same each second is written once
  known = told.bytes;
  writer_.put_calibration(told);
}

}  // namespace lcmslam
