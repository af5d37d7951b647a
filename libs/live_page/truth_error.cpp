#include <lcmslam/live_page/truth_error.hpp>

#include <algorithm>

namespace lcmslam {
namespace {
constexpr Utime remembered = 5'000'000;  // us
constexpr Utime longest_gap = 200'000;   // us between two true poses that are interpolated
}  // namespace

void TruthError::truth(Utime utime, const Eigen::Isometry3d& T_world_robot) {
  if (!truth_.empty() && utime <= truth_.back().first) truth_.clear();  // time began anew
  truth_.emplace_back(utime, T_world_robot);
  while (truth_.front().first < utime - remembered) truth_.pop_front();
}

std::optional<Eigen::Isometry3d> TruthError::at(Utime utime) const {
  const auto after = std::lower_bound(truth_.begin(), truth_.end(), utime,
                                      [](const auto& pose, Utime time) { return pose.first < time; });
  if (after == truth_.end()) return std::nullopt;
  if (after->first == utime) return after->second;
  if (after == truth_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const Utime gap = after->first - before->first;
  if (gap > longest_gap) return std::nullopt;
  const double share = static_cast<double>(utime - before->first) / static_cast<double>(gap);
  return interpolate(before->second, after->second, share);
}

std::optional<double> TruthError::error(const std::string& who, const std::string& frame, Utime utime,
                                        const Eigen::Isometry3d& T_map_robot) {
  const auto T_world_robot = at(utime);
  if (!T_world_robot) return std::nullopt;
  auto meeting = meetings_.find(who);
  if (meeting == meetings_.end() || meeting->second.frame != frame)
    meeting = meetings_.insert_or_assign(who, Meeting{frame, T_map_robot * T_world_robot->inverse()}).first;
  return distance_between(meeting->second.T_map_world * *T_world_robot, T_map_robot);
}

std::optional<Eigen::Isometry3d> TruthError::in_map(const std::string& who,
                                                    const Eigen::Isometry3d& T_world_robot) const {
  const auto meeting = meetings_.find(who);
  if (meeting == meetings_.end()) return std::nullopt;
  return meeting->second.T_map_world * T_world_robot;
}

}  // namespace lcmslam
