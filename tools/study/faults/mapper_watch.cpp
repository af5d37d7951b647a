#include "tools/study/faults/mapper_watch.hpp"

#include <cmath>
#include <limits>
#include <set>

#include <lcmslam/evaluation/trajectory_error.hpp>
#include <lcmslam/messages/geometry_messages.hpp>

namespace lcmslam {
namespace {

/// T_truth_estimate by positions and directions alike: positions of a way that is nearly straight leave it
/// open how the world is turned about that way, and all that comes later would seem to be wrong.
Eigen::Isometry3d laid_onto_truth(const std::vector<MatchedPose>& matches) {
  Eigen::Vector4d turn = Eigen::Vector4d::Zero();
  Eigen::Vector3d truth = Eigen::Vector3d::Zero(), estimate = Eigen::Vector3d::Zero();
  for (const MatchedPose& match : matches) {
    const Eigen::Quaterniond q(match.T_world_truth.linear() * match.T_world_estimate.linear().transpose());
    turn += q.coeffs().dot(turn) < 0 ? -q.coeffs() : q.coeffs();
    truth += match.T_world_truth.translation();
    estimate += match.T_world_estimate.translation();
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(turn.normalized()).toRotationMatrix();
  T.translation() = (truth - T.linear() * estimate) / static_cast<double>(matches.size());
  return T;
}

}  // namespace

void MapperWatch::add(const pose_estimate_t& message, double at) {
  const bool tracking =
      message.status == pose_estimate_t::TRACKING || message.status == pose_estimate_t::RELOCALISED;
  poses_.push_back({at,
                    message.utime,
                    from_message(message.T_map_robot, "T_map_robot"),
                    tracking,
                    {message.sender, message.frame}});
}

std::size_t MapperWatch::sessions() const {
  std::set<std::pair<std::int64_t, std::string>> sessions;
  for (const Pose& pose : poses_) sessions.insert(pose.session);
  return sessions.size();
}

double MapperWatch::ate(const Trajectory& truth) const {
  Trajectory tracked;
  for (const Pose& pose : poses_)
    if (pose.tracking && pose.session == poses_.front().session)
      tracked.push_back({pose.utime, pose.T_map_robot});
  sort_trajectory(tracked);
  EvaluationSettings settings;
  settings.association = Association::interpolate_truth;
  try {
    return evaluate(truth, tracked, settings).absolute.translation.rmse;
  } catch (const std::invalid_argument&) {  // nothing matches
    return std::numeric_limits<double>::quiet_NaN();
  }
}

std::vector<MapperWatch::Held> MapperWatch::held(const Trajectory& truth, Utime undisturbed) const {
  std::map<std::pair<std::int64_t, std::string>, Eigen::Isometry3d> T_world_map;
  Trajectory first;
  for (const Pose& pose : poses_)
    if (pose.tracking && pose.utime < undisturbed && pose.session == poses_.front().session)
      first.push_back({pose.utime, pose.T_map_robot});
  sort_trajectory(first);
  if (first.size() >= 10) {
    EvaluationSettings settings;
    settings.association = Association::interpolate_truth;
    const auto matches = associate(truth, first, settings);
    if (matches.size() >= 10) T_world_map[poses_.front().session] = laid_onto_truth(matches);
  }

  std::vector<Held> held;
  for (const Pose& pose : poses_) {
    const auto true_pose = pose_at(truth, pose.utime);
    if (!true_pose) continue;
    const auto [map, is_new] = T_world_map.try_emplace(pose.session, *true_pose * pose.T_map_robot.inverse());
    const double error = ((map->second * pose.T_map_robot).translation() - true_pose->translation()).norm();
    held.push_back({pose.at, pose.tracking, error, pose.utime});
  }
  return held;
}

MapperWatch::FalseTracking MapperWatch::longest_false_tracking(const Trajectory& truth, Utime undisturbed,
                                                               double limit) const {
  FalseTracking longest, now;
  for (const Held& pose : held(truth, undisturbed)) {
    if (!pose.tracking || !(pose.error > limit)) {
      now = {};
      continue;
    }
    if (now.begin == 0) now.begin = pose.utime;
    now.seconds = 1e-6 * static_cast<double>(pose.utime - now.begin);
    now.error = std::max(now.error, pose.error);
    if (now.seconds >= longest.seconds) longest = now;
  }
  return longest;
}

}  // namespace lcmslam
