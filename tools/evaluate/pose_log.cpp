#include "tools/evaluate/pose_log.hpp"

#include <fmt/format.h>
#include <array>
#include <filesystem>
#include <fstream>
#include <limits>

#include <lcmslam/graph_t.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/pose_t.hpp>
#include "tools/log/message_reader.hpp"

namespace lcmslam {
namespace {

constexpr Utime latest = 9'000'000'000'000'000;  // us; what exceeds it is garbage
constexpr Utime rewind_time = 1'000'000;         // us; a pose that comes this late belongs to another run

std::uint64_t fingerprint_of(const std::uint8_t* data, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(8, size); ++i) value = (value << 8) | data[i];
  return value;
}

Utime checked(Utime utime) {
  check_range(static_cast<double>(utime), 0, static_cast<double>(latest), "utime");
  return utime;
}

// A covariance that is none spoils no pose.
std::optional<Matrix6d> published_covariance(const pose_estimate_t& m) {
  try {
    return covariance_from_message(m.covariance, "covariance");
  } catch (const DecodeError&) {
    return std::nullopt;
  }
}

}  // namespace

void PoseLog::add(const std::string& channel, const std::uint8_t* data, std::size_t size) {
  const std::uint64_t fingerprint = fingerprint_of(data, size);
  const MessageType* const type = MessageType::find(fingerprint);
  const std::string name = type != nullptr ? type->name : fmt::format("fingerprint {:016x}", fingerprint);
  try {
    if (name == "ground_truth_t") {
      const auto m = decode_message<ground_truth_t>(data, size);
      add_pose(channel, {checked(m.utime), from_message(m.T_frame_child, "T_frame_child")}, 0, 0, 0);
      channels_[channel].body = m.child_frame;
      channels_[channel].frame = m.frame;
    } else if (name == "odometry_t") {
      const auto m = decode_message<odometry_t>(data, size);
      add_pose(channel, {checked(m.utime), from_message(m).T_odom_robot}, m.sender, m.status, 0);
      channels_[channel].body = m.child_frame;
      channels_[channel].frame = m.frame;
      channels_[channel].source = m.source;
    } else if (name == "pose_estimate_t") {
      const auto m = decode_message<pose_estimate_t>(data, size);
      add_pose(channel,
               {checked(m.utime), from_message(m.T_map_robot, "T_map_robot"), published_covariance(m)},
               m.sender, m.status, m.map_revision);
      channels_[channel].body = m.child_frame;
      channels_[channel].frame = m.frame;
      add_relative_pose(channel, channels_[channel].trajectory.back(), m.sender);
    } else if (name == "graph_t") {
      const auto m = decode_message<graph_t>(data, size);
      FollowedGraph& graph = followed_[{m.sender, m.frame}];
      graph.apply(m);
      Nodes nodes;
      for (const KeyframePose& pose : graph.poses()) nodes[pose.id] = pose.T_world_camera;
      add_graph(m.sender, std::move(nodes));
    } else if (name == "pose_t") {
      const auto m = decode_message<pose_t>(data, size);
      add_pose(channel, {checked(m.utime), from_message(m)}, 0, 0, 0);
      channels_[channel].body = "robot";
    } else if (name == "camera_calibration_t" && !calibration_) {
      calibration_ = from_message(decode_message<camera_calibration_t>(data, size));
    }
  } catch (const DecodeError&) {
    if (channels_.count(channel) > 0) ++channels_[channel].undecodable;
  }
  if (channels_.count(channel) > 0)
    channels_[channel].type = name;
  else
    others_[channel] = name;
}

void PoseLog::add_pose(const std::string& channel, const StampedPose& pose, std::int64_t sender, int status,
                       std::int64_t map_revision) {
  PoseChannel& path = channels_[channel];
  Mapper& mapper = mappers_[channel];
  const bool restarted =
      (mapper.sender != 0 && mapper.sender != sender) || map_revision < mapper.map_revision;
  const bool rewound = !path.trajectory.empty() && pose.utime < path.trajectory.back().utime - rewind_time;
  if (restarted || rewound) {  // another map, another frame: earlier poses do not compare
    path.left_out += static_cast<std::int64_t>(path.trajectory.size());
    path.trajectory.clear();
    path.relative_poses.clear();
    path.earlier_lost += path.lost;
    path.lost = path.degraded = 0;
    ++path.restarts;
  }
  mapper = {sender, map_revision};
  path.trajectory.push_back(pose);
  path.lost += status == pose_estimate_t::LOST ? 1 : 0;
  path.degraded += status == pose_estimate_t::DEGRADED ? 1 : 0;
}

// A mapper that keeps its graph bounded gives nodes up; what was seen from them goes with the nearest one.
void PoseLog::add_graph(std::int64_t sender, Nodes nodes) {
  for (const auto& [id, T_map_gone] : graphs_[sender]) {
    if (nodes.count(id) > 0) continue;
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [other, T_map_other] : graphs_[sender]) {
      const double distance = (T_map_other.translation() - T_map_gone.translation()).norm();
      if (nodes.count(other) == 0 || distance >= least) continue;
      least = distance;
      successors_[sender][id] = {other, T_map_other.inverse() * T_map_gone};
    }
  }
  for (const auto& [id, pose] : nodes) successors_[sender].erase(id);
  graphs_[sender] = std::move(nodes);
}

std::optional<Eigen::Isometry3d> PoseLog::final_pose(std::int64_t sender, std::int32_t node) const {
  const Nodes& nodes = graphs_.at(sender);
  Eigen::Isometry3d T_node_asked = Eigen::Isometry3d::Identity();
  const auto successors = successors_.find(sender);
  for (std::size_t steps = 0; nodes.count(node) == 0; ++steps) {
    if (successors == successors_.end() || successors->second.count(node) == 0 ||
        steps > successors->second.size())
      return std::nullopt;
    const Successor& successor = successors->second.at(node);
    T_node_asked = successor.T_successor_gone * T_node_asked;
    node = successor.node;
  }
  return nodes.at(node) * T_node_asked;
}

void PoseLog::add_relative_pose(const std::string& channel, const StampedPose& pose, std::int64_t sender) {
  const auto graph = graphs_.find(sender);
  if (graph == graphs_.end() || graph->second.empty()) return;
  const auto& [node, T_map_camera] = *graph->second.rbegin();
  channels_[channel].relative_poses.push_back({pose.utime, node, T_map_camera.inverse() * pose.T_world_body});
}

void PoseLog::add_final_paths() {
  std::map<std::string, PoseChannel> finals;
  for (const auto& [name, channel] : channels_) {
    const auto graph = graphs_.find(mappers_[name].sender);
    if (channel.relative_poses.empty() || graph == graphs_.end()) continue;
    PoseChannel path = channel;
    path.trajectory.clear();
    for (const PoseChannel::RelativePose& relative : channel.relative_poses)
      if (const auto T_map_camera = final_pose(graph->first, relative.node))
        path.trajectory.push_back({relative.utime, *T_map_camera * relative.T_node_robot});
    path.unplaced = static_cast<std::int64_t>(channel.trajectory.size() - path.trajectory.size());
    finals[name.substr(0, name.rfind("_POSE")) + "_FINAL"] = std::move(path);
  }
  channels_.merge(finals);
}

void PoseLog::finish(std::size_t damages) {
  damages_ = damages;
  add_final_paths();
  for (auto& [name, channel] : channels_) sort_trajectory(channel.trajectory);
}

const PoseChannel& PoseLog::channel(const std::string& name, const std::string& log) const {
  if (const auto found = channels_.find(name); found != channels_.end()) return found->second;
  std::string choices;
  for (const auto& [channel, path] : channels_) choices += (choices.empty() ? "" : ", ") + channel;
  const auto other = others_.find(name);
  throw std::runtime_error(log + ": " +
                           (other == others_.end()
                                ? "has no channel " + name
                                : "channel " + name + " carries no poses but " + other->second) +
                           "; channels with poses: " + (choices.empty() ? "none" : choices));
}

PoseLog read_pose_log(const std::string& file) {
  auto log = MessageReader::of_all(file);
  PoseLog poses;
  while (const auto event = log.next()) poses.add(std::string(event->channel), event->data, event->size);
  poses.finish(log.damages().size());
  return poses;
}

bool is_log(const std::string& file) {
  if (std::filesystem::path(file).extension() == ".lcmlog") return true;
  constexpr std::array<unsigned char, 4> sync = {0xed, 0xa1, 0xda, 0x01};
  std::ifstream bytes(file, std::ios::binary);
  for (const unsigned char expected : sync)
    if (bytes.get() != expected) return false;
  return true;
}

}  // namespace lcmslam
