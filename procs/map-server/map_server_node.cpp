#include "procs/map-server/map_server_node.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <set>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/runtime/confirmation.hpp>
#include <lcmslam/status_t.hpp>

namespace lcmslam {
namespace {

constexpr Utime resend_period = 2'000'000;   // us of message time between two requests
constexpr Utime longest_behind = 1'000'000;  // us that a map may be older than its mapper's poses say

std::size_t size(int setting) {
  return static_cast<std::size_t>(setting);
}

template <class M>
SessionKey key_of(const M& message) {
  return {message.sender, message.frame};
}

/// For what a message says that cannot be, or that there is no room for: it is counted, and STATUS tells it.
[[noreturn]] void refuse(const std::string& why) {
  throw DecodeError(why);
}

template <class Map, class M>
auto& session_of(SessionTable<Map>& sessions, const M& message) {
  auto* session = sessions.session(key_of(message));
  if (session == nullptr)
    refuse(
        fmt::format("sender {} is not the mapper that is alive, or max_sessions are there", message.sender));
  return *session;
}

/// Keyframes of the map that stay when the message has been followed.
std::size_t kept_by(const graph_t& message, const DenseMap& map) {
  const auto& keyframes = map.keyframes();
  std::set<std::int32_t> named;
  const auto name = [&](std::int32_t id) {
    if (keyframes.count(id) > 0) named.insert(id);
  };
  for (const graph_node_t& node : message.nodes) name(node.keyframe);
  if (message.change == 0) return named.size();
  named.clear();
  for (const std::int32_t id : message.gone) name(id);
  return keyframes.size() - named.size();
}

}  // namespace

MapServerSettings MapServerNode::read(const ConfigNode& config) {
  return read_settings<MapServerSettings>(config);
}

MapServerNode::MapServerNode(const ConfigNode& config, Publisher& publisher)
    : MapServerNode(read(config), publisher) {}

MapServerNode::MapServerNode(const MapServerSettings& settings, Publisher& publisher)
    : publisher_(publisher),
      folder_(settings.folder),
      resolution_(settings.resolution),
      landmark_maps_(size(settings.max_sessions), LandmarkMap(size(settings.max_landmarks))),
      dense_maps_(
          size(settings.max_sessions),
          DenseMap({size(settings.max_keyframes), size(settings.max_points), size(settings.max_incomplete)})),
      max_path_(size(settings.max_path)),
      snapshot_period_(settings.snapshot_period),
      most_export_folders_(size(settings.export_folders)) {}

void MapServerNode::connect(Inputs& inputs) {
  inputs.subscribe<landmarks_t>("FASTSLAM_LANDMARKS", 1000,
                                [this](const landmarks_t& m) { on_landmarks(m); });
  inputs.subscribe<keyframe_t>("ICP_KEYFRAME", 1000, [this](const keyframe_t& m) { on_keyframe(m); });
  inputs.subscribe<graph_t>("ICP_GRAPH", 10, [this](const graph_t& m) { on_graph(m); });
  // Of several senders of poses the first is kept while it is alive: it is the mapper.
  inputs.subscribe_measured<pose_estimate_t>("FASTSLAM_POSE", 1000,
                                             [this](const pose_estimate_t& m) { on_fastslam_pose(m); });
  inputs.subscribe_measured<pose_estimate_t>("ICP_POSE", 1000,
                                             [this](const pose_estimate_t& m) { on_icp_pose(m); });
  inputs.subscribe<map_request_t>("MAP_REQUEST", 100, [this](const map_request_t& m) { on_request(m); })
      .primary = true;
}

void MapServerNode::on_fastslam_pose(const pose_estimate_t& message) {
  if (landmark_maps_.hear(key_of(message))) fastslam_path_.clear();
  add_to_path(fastslam_path_, message);
  const auto* session = landmark_maps_.find(key_of(message));
  const bool complete = session != nullptr && !session->map.incomplete();
  follow("fastslam", message, complete ? session->map.revision() : 0);
}

void MapServerNode::on_icp_pose(const pose_estimate_t& message) {
  if (dense_maps_.hear(key_of(message))) icp_path_.clear();
  add_to_path(icp_path_, message);
  const auto* session = dense_maps_.find(key_of(message));
  if (session == nullptr) return follow("icp", message, 0);
  if (!session->graph.complete()) return follow("icp", message, 0);
  // The pose counts all keyframes that were made, the graph those that are kept.
  const std::int64_t kept = session->graph.map_revision();
  const std::int64_t given_up = kept > 0 ? std::max<std::int64_t>(0, message.map_revision - kept) : 0;
  follow("icp", message, static_cast<std::int64_t>(session->map.keyframes().size()) + given_up);
}

void MapServerNode::add_to_path(Path& path, const pose_estimate_t& message) const {
  path.push_back(from_message(message.T_map_robot, "T_map_robot").translation());
  if (path.size() <= max_path_) return;
  for (std::size_t i = 0; 2 * i < path.size(); ++i) path[i] = path[2 * i];
  path.resize((path.size() + 1) / 2);
}

void MapServerNode::on_landmarks(const landmarks_t& message) {
  const std::vector<Landmark> landmarks = landmarks_of(message);
  LandmarkMap& map = session_of(landmark_maps_, message).map;
  // A mapper takes away a few landmarks at a time. Who takes the most of a map away leaves it beside.
  const bool may_take_most = message.base_revision == 0 || 2 * message.removed.size() > map.size();
  std::optional<LandmarkMap> before;
  if (may_take_most && map.size() > 0) before = map;
  try {
    if (message.base_revision == 0 && message.n_tiles > 1)
      map.add_tile({message.map_revision, message.tile, message.n_tiles, landmarks});
    else
      map.apply({message.map_revision, message.base_revision, landmarks, message.removed});
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
  ++changes_;
  if (!before || 2 * map.size() >= before->size() || landmark_maps_.keep_beside(key_of(message), *before))
    return;
  map = std::move(*before);
  refuse("it takes away the most of a map, and there is no room to keep that beside");
}

void MapServerNode::on_keyframe(const keyframe_t& message) {
  const KeyframeTile tile = from_message(message);
  DenseMap& map = session_of(dense_maps_, message).map;
  try {
    map.add(tile);
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
  ++changes_;
}

void MapServerNode::on_graph(const graph_t& message) {
  from_message(message);  // throws before anything is kept beside
  auto* session = &session_of(dense_maps_, message);
  if (2 * kept_by(message, session->map) < session->map.keyframes().size() &&
      !dense_maps_.keep_beside(key_of(message), session->map))
    refuse("it takes away the most of a map, and there is no room to keep that beside");
  session = dense_maps_.find(key_of(message));
  session->graph.apply(message);
  lcmslam::follow(session->map, session->graph, message);
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
      for (const auto& file : export_maps(request)) reply.message += file + "\n";
    } else if (request.kind != map_request_t::INFO) {
      throw std::runtime_error(fmt::format("there is no request of kind {}", request.kind));
    }
  } catch (const std::exception& error) {
    reply.status = 1;
    reply.message = error.what();
    ++requests_refused_;
    spdlog::error("request refused: {}", error.what());
  }
  const std::string info = describe();
  reply.content = "application/json";
  reply.data.assign(info.begin(), info.end());
  reply.size = static_cast<int32_t>(reply.data.size());
  publisher_.publish("MAP_REPLY", reply);
}

std::string MapServerNode::describe() const {
  const LandmarkMap* landmarks = landmark_maps_.current_map();
  const DenseMap* dense = dense_maps_.current_map();
  return fmt::format(R"({{"landmarks": {}, "keyframes": {}, "map_points": {}, "resolution": {}}})",
                     landmarks != nullptr ? landmarks->size() : 0,
                     dense != nullptr ? dense->keyframes().size() : 0,
                     dense != nullptr ? dense->merge(resolution_).size() : 0, resolution_);
}

std::vector<std::string> MapServerNode::export_maps(const map_request_t& request) {
  note_saving(true);  // both write files of the same names
  auto files = save_maps(maps_to_save(), export_folder(request.argument), request.format);
  if (request.argument.empty() && request.format.empty()) drawn_changes_ = changes_;
  return files;
}

/// The run's own folder, or the one below it that a request names.
HeldFolder MapServerNode::export_folder(const std::string& name) {
  std::filesystem::create_directories(folder_);
  const HeldFolder own(folder_);
  if (name.empty()) return own;
  if (export_folders_.count(name) == 0 && export_folders_.size() >= most_export_folders_)
    throw std::runtime_error(
        fmt::format("requests have made {} folders already, as many as export_folders lets them",
                    export_folders_.size()));
  HeldFolder folder = own.below(name);
  export_folders_.insert(name);
  return folder;
}

MapsToSave MapServerNode::maps_to_save() const {
  MapsToSave maps;
  maps.resolution = resolution_;
  // The current session of each mapper has the plain name, the others carry a number.
  for (std::size_t i = 0; i < landmark_maps_.size(); ++i)
    maps.landmarks.push_back({landmark_maps_.name("fastslam", i), landmark_maps_.all()[i].map.landmarks(),
                              i == landmark_maps_.current() ? fastslam_path_ : Path()});
  for (std::size_t i = 0; i < dense_maps_.size(); ++i)
    maps.dense.push_back({dense_maps_.name("icp", i), dense_maps_.all()[i].map,
                          i == dense_maps_.current() ? icp_path_ : Path()});
  return maps;
}

void MapServerNode::command(const command_t& command) {
  if (command.name == "save") save_beside();
  keep_what_is_reset(command);
}

/// A mapper is told to forget its map: as it is now it stays on disk, in a folder of its own.
void MapServerNode::keep_what_is_reset(const command_t& command) {
  const auto forgets = [&](const char* process, const auto& sessions) {
    return !sessions.empty() && is_confirmed(command, process, sessions.all()[sessions.current()].key.sender);
  };
  if (command.name != "reset" || !(forgets("fastslam", landmark_maps_) || forgets("icp", dense_maps_)))
    return;
  note_saving(true);
  int number = 1;
  const auto folder = [&] { return folder_ / fmt::format("before-reset-{}", number); };
  while (std::filesystem::exists(folder())) ++number;
  spdlog::info("reset: the maps so far are kept in {}", folder().string());
  saver_.begin(maps_to_save(), folder(), saved_changes_);
}

std::optional<Node::Duration> MapServerNode::work() {
  note_saving(false);
  const auto now = std::chrono::steady_clock::now();
  if (snapshot_period_ > 0 && now - last_snapshot_ >= std::chrono::duration<double>(snapshot_period_)) {
    last_snapshot_ = now;
    save_beside();
  }
  return std::nullopt;
}

/// What changed since it was saved is copied here and written by another thread.
void MapServerNode::save_beside() {
  note_saving(false);
  if (changes_ != saved_changes_ && !saver_.busy()) saver_.begin(maps_to_save(), folder_, changes_);
}

void MapServerNode::note_saving(bool wait) {
  const auto outcome = saver_.take_outcome(wait);
  if (!outcome) return;
  failure_ = outcome->error;
  if (!failure_.empty()) return spdlog::error("maps are not saved: {}", failure_);
  saved_changes_ = outcome->revision;
  ++saved_;
  spdlog::info("maps saved in {}", folder_.string());
}

/// Pictures too: drawing them takes too long while a run goes on.
void MapServerNode::finish() {
  note_saving(true);
  if (changes_ != saved_changes_ || changes_ != drawn_changes_)
    saver_.begin(maps_to_save(), folder_, changes_, "ply,pcd,png");
  note_saving(true);
}

NodeReport MapServerNode::report() const {
  NodeReport report;
  if (!failure_.empty()) report.detail = "maps are not saved: " + failure_;
  if (!failure_.empty() && changes_ != saved_changes_) report.state = status_t::FAILED;
  const LandmarkMap* landmarks = landmark_maps_.current_map();
  const DenseMap* dense = dense_maps_.current_map();
  std::int64_t given_up = 0;
  for (const auto& session : dense_maps_.all()) given_up += session.map.given_up();
  const auto number = [](auto value) { return static_cast<double>(value); };
  report.values = {{"landmarks", landmarks != nullptr ? number(landmarks->size()) : 0},
                   {"keyframes", dense != nullptr ? number(dense->keyframes().size()) : 0},
                   {"map_points", dense != nullptr ? number(dense->point_count()) : 0},
                   {"sessions", number(std::max(landmark_maps_.size(), dense_maps_.size()))},
                   {"sessions_refused", number(landmark_maps_.refused() + dense_maps_.refused())},
                   {"keyframes_given_up", number(given_up)},
                   {"resends_asked", number(resends_)},
                   {"saved", number(saved_)},
                   {"unsaved", number(changes_ - saved_changes_)},
                   {"requests_refused", number(requests_refused_)}};
  return report;
}

}  // namespace lcmslam
