#include "procs/map-server/map_server_node.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include "procs/map-server/map_files.hpp"

namespace lcmslam {
namespace {

constexpr Utime resend_period = 2'000'000;   // us of message time between two requests
constexpr Utime longest_behind = 1'000'000;  // us that a map may be older than its mapper's poses say

/// nullptr when this sender has none.
template <class Map>
Map* find_map(std::vector<Session<Map>>& sessions, std::int64_t sender) {
  for (auto& session : sessions)
    if (session.sender == sender) return &session.map;
  return nullptr;
}

/// The map of this sender, begun when it has none; then the newest mapper's path begins anew.
template <class Map>
Map& session_map(std::vector<Session<Map>>& sessions, std::int64_t sender,
                 std::vector<Eigen::Vector3d>& path) {
  if (Map* map = find_map(sessions, sender)) return *map;
  if (!sessions.empty()) spdlog::info("a mapper restarted: its new map begins beside the old one");
  path.clear();
  sessions.push_back({sender, {}});
  return sessions.back().map;
}

void add_to_path(std::vector<Eigen::Vector3d>& path, const pose_estimate_t& message) {
  path.push_back(from_message(message.T_map_robot, "T_map_robot").translation());
}

}  // namespace

MapServerSettings MapServerNode::read(const ConfigNode& config) {
  return read_settings<MapServerSettings>(config);
}

MapServerNode::MapServerNode(const ConfigNode& config, Publisher& publisher)
    : MapServerNode(read(config), publisher) {}

MapServerNode::MapServerNode(const MapServerSettings& settings, Publisher& publisher)
    : publisher_(publisher), folder_(settings.folder), resolution_(settings.resolution) {}

void MapServerNode::connect(Inputs& inputs) {
  inputs.subscribe<landmarks_t>("FASTSLAM_LANDMARKS", 1000,
                                [this](const landmarks_t& m) { on_landmarks(m); });
  inputs.subscribe<keyframe_t>("ICP_KEYFRAME", 1000, [this](const keyframe_t& m) { on_keyframe(m); });
  inputs.subscribe<graph_t>("ICP_GRAPH", 10, [this](const graph_t& m) { on_graph(m); });
  inputs.subscribe<pose_estimate_t>("FASTSLAM_POSE", 1000, [this](const pose_estimate_t& m) {
    add_to_path(fastslam_path_, m);
    const LandmarkMap* map = find_map(landmark_maps_, m.sender);
    follow("fastslam", m, map != nullptr && !map->incomplete() ? map->revision() : 0);
  });
  inputs.subscribe<pose_estimate_t>("ICP_POSE", 1000, [this](const pose_estimate_t& m) {
    add_to_path(icp_path_, m);
    const DenseMap* map = find_map(dense_maps_, m.sender);
    // The pose counts all keyframes that were made, the graph those that are kept.
    const std::int64_t given_up =
        graph_sender_ == m.sender ? std::max<std::int64_t>(0, m.map_revision - graph_keyframes_) : 0;
    follow("icp", m, map != nullptr ? static_cast<std::int64_t>(map->keyframes().size()) + given_up : 0);
  });
  inputs.subscribe<map_request_t>("MAP_REQUEST", 100, [this](const map_request_t& m) { on_request(m); })
      .primary = true;
}

void MapServerNode::on_landmarks(const landmarks_t& message) {
  std::vector<Landmark> landmarks = landmarks_of(message);
  LandmarkMap& map = session_map(landmark_maps_, message.sender, fastslam_path_);
  try {
    if (message.base_revision == 0 && message.n_tiles > 1)
      map.add_tile({message.map_revision, message.tile, message.n_tiles, std::move(landmarks)});
    else
      map.apply({message.map_revision, message.base_revision, std::move(landmarks), message.removed});
  } catch (const std::invalid_argument& error) {
    throw DecodeError(error.what());
  }
  ++changes_;
}

void MapServerNode::on_keyframe(const keyframe_t& message) {
  const KeyframeTile tile = from_message(message);
  DenseMap& map = session_map(dense_maps_, message.sender, icp_path_);
  try {
    map.add(tile);
  } catch (const std::invalid_argument& error) {
    throw DecodeError(error.what());
  }
  ++changes_;
}

void MapServerNode::on_graph(const graph_t& message) {
  DenseMap* map = find_map(dense_maps_, message.sender);
  graph_sender_ = message.sender;
  graph_keyframes_ = message.map_revision;
  if (map == nullptr) return;
  map->follow(from_message(message));
  ++changes_;
}

// A map that stays behind what its mapper's poses name has lost something: this server restarted, or a
// message did not arrive.
void MapServerNode::follow(const std::string& process, const pose_estimate_t& pose, std::int64_t revision) {
  Progress& progress = progress_[process];
  const bool behind = revision < pose.map_revision;
  const bool watched = progress.up_to_date != 0 && pose.utime >= progress.up_to_date;
  if (!behind || !watched) progress.up_to_date = pose.utime;
  if (pose.utime < progress.asked) progress.asked = 0;
  if (pose.utime - progress.up_to_date < longest_behind || pose.utime - progress.asked < resend_period)
    return;
  progress.asked = pose.utime;
  ++resends_;
  command_t command;
  command.utime = pose.utime;
  command.target = process;
  command.name = "resend";
  command.n = 0;
  publisher_.publish("COMMAND", command);
}

void MapServerNode::on_request(const map_request_t& request) {
  map_reply_t reply;
  reply.utime = request.utime;
  reply.request_id = request.request_id;
  reply.status = 0;
  reply.tile = 0;
  reply.n_tiles = 1;
  try {
    if (request.kind == map_request_t::EXPORT) {
      for (const auto& file : export_maps(
               request.argument.empty() ? folder_ : std::filesystem::path(request.argument), request.format))
        reply.message += file + "\n";
    } else if (request.kind != map_request_t::INFO) {
      throw std::runtime_error(fmt::format("there is no request of kind {}", request.kind));
    }
  } catch (const std::exception& error) {
    reply.status = 1;
    reply.message = error.what();
    spdlog::error("{}", error.what());
  }
  const std::string info = describe();
  reply.content = "application/json";
  reply.data.assign(info.begin(), info.end());
  reply.size = static_cast<int32_t>(reply.data.size());
  publisher_.publish("MAP_REPLY", reply);
}

std::string MapServerNode::describe() const {
  const std::size_t landmarks = landmark_maps_.empty() ? 0 : landmark_maps_.back().map.size();
  const std::size_t keyframes = dense_maps_.empty() ? 0 : dense_maps_.back().map.keyframes().size();
  const std::size_t points = dense_maps_.empty() ? 0 : dense_maps_.back().map.merge(resolution_).size();
  return fmt::format(R"({{"landmarks": {}, "keyframes": {}, "map_points": {}, "resolution": {}}})", landmarks,
                     keyframes, points, resolution_);
}

std::vector<std::string> MapServerNode::export_maps(const std::filesystem::path& folder,
                                                    const std::string& formats) const {
  std::filesystem::create_directories(folder);
  MapFiles files(folder, formats);
  // Older sessions carry a number, the newest of each mapper has the plain name.
  for (std::size_t i = 0; i < landmark_maps_.size(); ++i) {
    const bool newest = i + 1 == landmark_maps_.size();
    files.save_landmarks(newest ? "fastslam" : fmt::format("fastslam-session{}", i + 1),
                         landmark_maps_[i].map.landmarks(), newest ? fastslam_path_ : Path());
  }
  for (std::size_t i = 0; i < dense_maps_.size(); ++i) {
    const bool newest = i + 1 == dense_maps_.size();
    files.save_cloud(newest ? "icp" : fmt::format("icp-session{}", i + 1),
                     dense_maps_[i].map.merge(resolution_), resolution_, newest ? icp_path_ : Path());
  }
  return files.written();
}

void MapServerNode::command(const command_t& command) {
  if (command.name == "save") finish();
}

void MapServerNode::finish() {
  if (changes_ == saved_changes_) return;
  try {
    export_maps(folder_, "ply,pcd");
    saved_changes_ = changes_;
    ++exports_;
    spdlog::info("maps saved in {}", folder_.string());
  } catch (const std::exception& error) {
    spdlog::error("maps are not saved: {}", error.what());
  }
}

NodeReport MapServerNode::report() const {
  NodeReport report;
  report.values = {
      {"landmarks", landmark_maps_.empty() ? 0 : static_cast<double>(landmark_maps_.back().map.size())},
      {"keyframes", dense_maps_.empty() ? 0 : static_cast<double>(dense_maps_.back().map.keyframes().size())},
      {"map_points", dense_maps_.empty() ? 0 : static_cast<double>(dense_maps_.back().map.point_count())},
      {"sessions", static_cast<double>(std::max(landmark_maps_.size(), dense_maps_.size()))},
      {"resends_asked", static_cast<double>(resends_)}};
  return report;
}

}  // namespace lcmslam
