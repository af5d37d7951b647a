#include "tools/study/told_keyframes.hpp"

#include <lcmslam/graph_covariance_t.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>

namespace lcmslam {
namespace {

const char* const first_map = "map";

}  // namespace

void ToldKeyframes::hear(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  if (channel == "ICP_GRAPH") {
    const auto graph = decode_message<graph_t>(bytes.data(), bytes.size());
    if (graph.frame == first_map) graph_.apply(graph);
  } else if (channel == "ICP_GRAPH_COVARIANCE") {
    const auto told = decode_message<graph_covariance_t>(bytes.data(), bytes.size());
    if (told.frame != first_map) return;
    for (const node_covariance_t& node : told.nodes) covariances_[node.keyframe] = from_message(node);
  } else if (channel == "ICP_KEYFRAME") {
    const auto tile = decode_message<keyframe_t>(bytes.data(), bytes.size());
    if (tile.frame == first_map) mounts_[tile.id] = from_message(tile.T_robot_camera, "T_robot_camera");
  }
}

Trajectory ToldKeyframes::path() const {
  Trajectory path;
  for (const auto& [id, node] : graph_.nodes()) {
    const auto mount = mounts_.find(id);
    if (mount == mounts_.end()) continue;
    StampedPose camera{node.keyframe_utime, from_message(node.T_map_camera, "T_map_camera"), {}};
    const auto covariance = covariances_.find(id);
    if (covariance != covariances_.end()) camera.covariance = covariance->second;
    path.push_back(in_other_frame({camera}, mount->second.inverse()).front());
  }
  sort_trajectory(path);
  return path;
}

}  // namespace lcmslam
