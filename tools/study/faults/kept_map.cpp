#include "tools/study/faults/kept_map.hpp"

#include <limits>
#include <set>

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

}  // namespace

KeptMap judge_kept_map(const std::filesystem::path& file, const ToldGraphs& told, const Trajectory& truth,
                       const Eigen::Isometry3d& T_robot_camera) {
  KeptMap kept;
  MapFile map(file);
  std::set<std::pair<ToldGraphs::key_type, std::int32_t>> stored;
  Trajectory placed;
  for (const StoredSession& session : map.sessions()) {
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
  kept.placed = static_cast<int>(placed.size());
  kept.error = rmse(truth, placed);
  return kept;
}

}  // namespace lcmslam
