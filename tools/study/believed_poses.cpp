#include "tools/study/believed_poses.hpp"

#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/pose_estimate_t.hpp>

namespace lcmslam {
namespace {

bool is_believed(const pose_estimate_t& pose) {
  return pose.frame == "map" &&
         (pose.status == pose_estimate_t::TRACKING || pose.status == pose_estimate_t::DEGRADED ||
          pose.status == pose_estimate_t::RELOCALISED);
}

}  // namespace

void BelievedPoses::hear(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  if (channel != "ICP_POSE" && channel != "FASTSLAM_POSE") return;
  const auto pose = decode_message<pose_estimate_t>(bytes.data(), bytes.size());
  BelievedPath& own = heard_[channel];
  if (is_believed(pose))
    own.path.push_back({pose.utime, from_message(pose.T_map_robot, "T_map_robot"),
                        covariance_from_message(pose.covariance, "covariance")});
  else
    ++own.left_out;
}

std::map<std::string, BelievedPath> BelievedPoses::paths() const {
  std::map<std::string, BelievedPath> sorted = heard_;
  for (auto& [channel, own] : sorted) sort_trajectory(own.path);
  return sorted;
}

}  // namespace lcmslam
