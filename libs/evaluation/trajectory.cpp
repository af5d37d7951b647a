#include <lcmslam/evaluation/trajectory.hpp>

#include <algorithm>

namespace lcmslam {
namespace {

bool earlier(const StampedPose& a, const StampedPose& b) {
  return a.utime < b.utime;
}

}  // namespace

void sort_trajectory(Trajectory& trajectory) {
  std::stable_sort(trajectory.begin(), trajectory.end(), earlier);
  const auto same_stamp = [](const StampedPose& a, const StampedPose& b) { return a.utime == b.utime; };
  // std::unique keeps the first of its run: go from the back.
  const auto first = std::unique(trajectory.rbegin(), trajectory.rend(), same_stamp).base();
  trajectory.erase(trajectory.begin(), first);
}

Trajectory in_other_frame(const Trajectory& trajectory, const Eigen::Isometry3d& T_body_other) {
  Trajectory other = trajectory;
  const Matrix6d A = adjoint(T_body_other.inverse());
  for (StampedPose& pose : other) {
    pose.T_world_body = pose.T_world_body * T_body_other;
    if (pose.covariance) pose.covariance = (A * *pose.covariance * A.transpose()).eval();
  }
  return other;
}

std::optional<Eigen::Isometry3d> pose_at(const Trajectory& trajectory, Utime utime, double max_gap) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), StampedPose{utime, {}}, earlier);
  if (after == trajectory.end()) return std::nullopt;
  if (after->utime == utime) return after->T_world_body;
  if (after == trajectory.begin()) return std::nullopt;
  const StampedPose& a = *std::prev(after);
  const auto gap = static_cast<double>(after->utime - a.utime);
  if (gap > 1e6 * max_gap) return std::nullopt;
  return interpolate(a.T_world_body, after->T_world_body, static_cast<double>(utime - a.utime) / gap);
}

double path_length(const Trajectory& trajectory) {
  double length = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length +=
        (trajectory[i].T_world_body.translation() - trajectory[i - 1].T_world_body.translation()).norm();
  }
  return length;
}

}  // namespace lcmslam
