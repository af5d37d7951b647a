#include "tools/study/faults/kept_map.hpp"

#include <algorithm>
#include <limits>

#include <lcmslam/evaluation/trajectory_error.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/pose_estimate_t.hpp>

namespace lcmslam {
namespace {

double rmse(const Trajectory& truth, Trajectory estimate) {
  sort_trajectory(estimate);
  EvaluationSettings settings;
  settings.association = Association::interpolate_truth;
  try {
    return evaluate(truth, estimate, settings).absolute.translation.rmse;
  } catch (const std::invalid_argument&) {  // nothing matches
    return std::numeric_limits<double>::quiet_NaN();
  }
}

/// s between two neighbours, at most.
double longest_gap(std::vector<Utime> times) {
  std::sort(times.begin(), times.end());
  Utime gap = 0;
  for (std::size_t i = 1; i < times.size(); ++i) gap = std::max(gap, times[i] - times[i - 1]);
  return 1e-6 * static_cast<double>(gap);
}

/// Without those whose mapper never told a pose.
template <class Map>
std::map<ToldMaps::Key, Map> of_mappers(std::map<ToldMaps::Key, Map> maps,
                                        const std::set<ToldMaps::Key>& mappers) {
  for (auto map = maps.begin(); map != maps.end();)
    map = mappers.count(map->first) > 0 ? std::next(map) : maps.erase(map);
  return maps;
}

}  // namespace

void ToldMaps::listen(Inputs& inputs) {
  inputs.subscribe<graph_t>("ICP_GRAPH", 1000, [this](const graph_t& m) {
    graphs_[{m.sender, m.frame}].apply(m);
  });
  inputs.subscribe<landmarks_t>("FASTSLAM_LANDMARKS", 1000, [this](const landmarks_t& m) { apply(m); });
  for (const auto& [channel, mappers] :
       {std::pair("ICP_POSE", &dense_mappers_), {"FASTSLAM_POSE", &sparse_mappers_}})
    inputs.subscribe<pose_estimate_t>(channel, 10000, [mappers = mappers](const pose_estimate_t& m) {
      mappers->insert({m.sender, m.frame});
    });
}

void ToldMaps::apply(const landmarks_t& message) {
  LandmarkMap& map = landmarks_[{message.sender, message.frame}];
  const std::vector<Landmark> landmarks = landmarks_of(message);
  if (message.base_revision == 0 && message.n_tiles > 1)
    map.add_tile({message.map_revision, message.tile, message.n_tiles, landmarks});
  else
    map.apply({message.map_revision, message.base_revision, landmarks, message.removed});
}

std::map<ToldMaps::Key, FollowedGraph> ToldMaps::graphs() const {
  return of_mappers(graphs_, dense_mappers_);
}

std::map<ToldMaps::Key, LandmarkMap> ToldMaps::landmarks() const {
  return of_mappers(landmarks_, sparse_mappers_);
}

void hear_out(Receiver& receiver, std::chrono::milliseconds silence) {
  Arrival arrival;
  while (receiver.take(arrival, silence)) arrival.deliver();
}

void KeptCount::add(bool is_kept, bool was_told_wholly) {
  ++told;
  if (!is_kept) ++(was_told_wholly ? lost : unjudged);
}

KeptMap judge_kept_map(const std::filesystem::path& file, const ToldMaps& told, const Trajectory& truth,
                       const Eigen::Isometry3d& T_robot_camera) {
  KeptMap kept;
  MapFile map(file);
  std::set<std::pair<ToldMaps::Key, std::int64_t>> stored_landmarks;
  std::map<std::string, std::vector<Utime>> poses;
  std::set<std::pair<ToldMaps::Key, std::int32_t>> stored;
  Trajectory placed;
  for (const StoredSession& session : map.sessions()) {
    for (const StoredPose& pose : map.trajectory(session.id)) poses[session.mapper].push_back(pose.utime);
    if (session.mapper == "fastslam")
      for (const Landmark& landmark : map.landmarks(session.id))
        stored_landmarks.insert({{session.sender, session.frame}, landmark.id});
    if (session.mapper != "icp") continue;
    const bool first = kept.sessions++ == 0;
    const bool joined = first || session.state == SessionState::joined;
    kept.joined += joined ? 1 : 0;
    const Eigen::Isometry3d T_map_session = session.T_map_session.value_or(Eigen::Isometry3d::Identity());
    for (const StoredKeyframe& keyframe : map.keyframes(session.id)) {
      stored.insert({{session.sender, session.frame}, keyframe.id});
      if (joined)
        placed.push_back({keyframe.utime, T_map_session * keyframe.T_map_camera * T_robot_camera.inverse()});
    }
  }
  for (const auto& [session, graph] : told.graphs())
    for (const auto& [id, node] : graph.nodes())
      kept.keyframes.add(stored.count({session, id}) > 0, graph.complete());
  for (const auto& [session, landmarks] : told.landmarks())
    for (const Landmark& landmark : landmarks.landmarks())
      kept.landmarks.add(stored_landmarks.count({session, landmark.id}) > 0, !landmarks.incomplete());
  kept.fastslam_gap = longest_gap(poses["fastslam"]);
  kept.icp_gap = longest_gap(poses["icp"]);
  kept.placed = static_cast<int>(placed.size());
  kept.error = rmse(truth, placed);
  return kept;
}

}  // namespace lcmslam
