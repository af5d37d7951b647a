#include "tools/study/faults/kept_map.hpp"

#include <algorithm>
#include <limits>

#include <lcmslam/evaluation/trajectory_error.hpp>
#include <lcmslam/map_store/file/map_file.hpp>

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

}  // namespace

void ToldLandmarks::apply(const landmarks_t& message) {
  std::set<std::int64_t>& ids = ids_[{message.sender, message.frame}];
  if (message.base_revision == 0 && message.tile == 0) ids.clear();
  for (const std::int64_t id : message.removed) ids.erase(id);
  for (const landmark_t& landmark : message.landmarks) ids.insert(landmark.id);
}

KeptMap judge_kept_map(const std::filesystem::path& file, const ToldGraphs& told,
                       const ToldLandmarks& told_landmarks, const Trajectory& truth,
                       const Eigen::Isometry3d& T_robot_camera) {
  KeptMap kept;
  MapFile map(file);
  std::set<std::pair<ToldGraphs::key_type, std::int64_t>> stored_landmarks;
  std::map<std::string, std::vector<Utime>> poses;
  std::set<std::pair<ToldGraphs::key_type, std::int32_t>> stored;
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
  for (const auto& [session, graph] : told) {
    for (const auto& [id, node] : graph.nodes()) {
      ++kept.told;
      kept.lost += stored.count({session, id}) == 0 ? 1 : 0;
    }
  }
  for (const auto& [session, ids] : told_landmarks.ids())
    for (const std::int64_t id : ids) {
      ++kept.landmarks_told;
      kept.landmarks_lost += stored_landmarks.count({session, id}) == 0 ? 1 : 0;
    }
  kept.fastslam_gap = longest_gap(poses["fastslam"]);
  kept.icp_gap = longest_gap(poses["icp"]);
  kept.placed = static_cast<int>(placed.size());
  kept.error = rmse(truth, placed);
  return kept;
}

}  // namespace lcmslam
