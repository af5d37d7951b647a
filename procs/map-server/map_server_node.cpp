#include "procs/map-server/map_server_node.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <set>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/runtime/confirmation.hpp>
#include <lcmslam/settings/check.hpp>
#include <lcmslam/status_t.hpp>

namespace lcmslam {
namespace {

constexpr Utime resend_period = 2'000'000;   // us of message time between two requests
constexpr Utime longest_behind = 1'000'000;  // us that a map may be older than its mapper's poses say

// Ids of the file's keyframes among those of the derived maps; mappers' own begin at 0.
constexpr int first_kept_id = 1'000'000'000;

constexpr int saving_pause = 50;  // times as long as a saving took, until the next
constexpr auto longest_settling = std::chrono::seconds(4);

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

/// A line a setting; without the page's, which make no map and may hold a token.
std::string text_of(MapServerSettings settings) {
  settings.page = {};
  std::string text;
  for (const SettingEntry& entry : list_settings(settings)) text += entry.path + ": " + entry.value + "\n";
  return text;
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
      localises_(settings.mode == "localise"),
      landmark_maps_(size(settings.max_sessions), LandmarkMap(size(settings.max_landmarks))),
      dense_maps_(
          size(settings.max_sessions),
          DenseMap({size(settings.max_keyframes), size(settings.max_points), size(settings.max_incomplete)})),
      max_path_(size(settings.max_path)),
      snapshot_period_(settings.snapshot_period),
      most_export_folders_(size(settings.export_folders)),
      desk_(settings.layers.map.background) {
  if (settings.layers.make) layers_.emplace(settings.layers);
  if (localises_ && !std::filesystem::exists(settings.map))
    throw std::runtime_error(settings.map.string() + ": there is no such map to localise in");
  const std::filesystem::path store = settings.store.empty() ? "" : folder_ / settings.store;
  if (settings.places) {
    const std::filesystem::path& map = localises_ ? settings.map : store;
    places_ = std::make_unique<SessionPlaces>(map, settings.layers.map.background);
    landmark_places_ = std::make_unique<LandmarkSessions>(map, settings.layers.map.background);
  }
  if (!localises_ && !store.empty()) recorder_.emplace(store, text_of(settings));
}

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
  stamps_ = &inputs.stamps();
  inputs.subscribe<camera_calibration_t>("CAMERA_CALIBRATION", 10,
                                         [this](const camera_calibration_t& m) { on_calibration(m); });
  if (recorder_ || places_)
    inputs.subscribe<features_t>("FEATURES", 100, [this](const features_t& m) { on_features(m); });
  if (layers_) inputs.subscribe_measured<images_t>("CAMERA", 10, [this](const images_t& m) { on_camera(m); });
}

void MapServerNode::on_fastslam_pose(const pose_estimate_t& message) {
  hear_fastslam(key_of(message));
  add_to_path(fastslam_path_, message);
  fastslam_pose_ = message;
  if (recorder_) recorder_->pose("fastslam", key_of(message), message);
  const auto* session = landmark_maps_.find(key_of(message));
  const bool complete = session != nullptr && !session->map.incomplete();
  follow("fastslam", message, complete ? session->map.revision() : 0);
}

void MapServerNode::hear_fastslam(const SessionKey& key) {
  const std::size_t last = landmark_maps_.empty() ? 0 : landmark_maps_.current();
  if (!landmark_maps_.hear(key)) return;
  fastslam_path_.clear();
  if (!landmark_places_) return;
  const bool was_another = !landmark_maps_.empty() && !(landmark_maps_.all()[last].key == key);
  landmark_places_->begin_session(
      recorder_ ? recorder_->stored("fastslam", key) : 0,
      was_another ? landmark_maps_.all()[last].map.landmarks() : std::vector<Landmark>());
}

void MapServerNode::on_icp_pose(const pose_estimate_t& message) {
  if (dense_maps_.hear(key_of(message))) {
    icp_path_.clear();
    if (layers_) layers_->begin_map();
    begin_places(key_of(message));
  }
  add_to_path(icp_path_, message);
  T_map_robot_ = from_message(message.T_map_robot, "T_map_robot");
  icp_pose_ = message;
  if (layers_ && message.status == pose_estimate_t::TRACKING) layers_->pose(message.utime, *T_map_robot_);
  if (recorder_) recorder_->pose("icp", key_of(message), message);
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
  bool whole = message.base_revision == 0;
  try {
    if (whole && message.n_tiles > 1)
      whole = map.add_tile({message.map_revision, message.tile, message.n_tiles, landmarks});
    else
      map.apply({message.map_revision, message.base_revision, landmarks, message.removed});
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
  ++changes_;
  if (before && 2 * map.size() < before->size()) keep_beside(message, map, std::move(*before));
  const auto* session = landmark_maps_.find(key_of(message));
  if (recorder_) recorder_->landmarks(session->key, message, session->map, whole);
  if (landmark_places_ && session == &landmark_maps_.all()[landmark_maps_.current()])
    landmark_places_->follow(session->map);
}

/// Whether the map's mapper is the one that is told and derived from.
bool MapServerNode::is_current(const SessionKey& key) const {
  return !dense_maps_.empty() && dense_maps_.all()[dense_maps_.current()].key == key;
}

void MapServerNode::on_calibration(const camera_calibration_t& message) {
  if (recorder_) recorder_->calibration(message);
  if (!layers_) return;
  if (layers_->calibration()) {
    if (is_of_another_camera(message.sender, calibration_message_.sender, *stamps_)) return;
    if (same_calibration(message, calibration_message_)) return;
  }
  layers_->calibrate(from_message(message));
  calibration_message_ = message;
}

void MapServerNode::on_camera(const images_t& message) {
  if (layers_->calibration()) layers_->camera(checked_images(message, *layers_->calibration()));
}

/// A message took the most of a map away: it stays beside as it was `before`, or else in its place.
void MapServerNode::keep_beside(const landmarks_t& message, LandmarkMap& map, LandmarkMap before) {
  if (!landmark_maps_.keep_beside(key_of(message), before)) {
    map = std::move(before);
    refuse("it takes away the most of a map, and there is no room to keep that beside");
  }
  const auto& kept = landmark_maps_.all().back();
  if (recorder_) recorder_->kept_beside(kept.key, kept.map);
}

void MapServerNode::on_keyframe(const keyframe_t& message) {
  const KeyframeTile tile = from_message(message);
  DenseMap& map = session_of(dense_maps_, message).map;
  bool complete = false;
  try {
    complete = map.add(tile);
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
  ++changes_;
  if (!complete) return;
  const DenseKeyframe& keyframe = map.keyframes().at(tile.part.id);
  if (recorder_) recorder_->keyframe(key_of(message), keyframe);
  if (const auto found = keyframe_features_.keyframe({key_of(message), keyframe.id, keyframe.utime}))
    remember(*found);
  if (layers_ && is_current(key_of(message))) derive_from(key_of(message), keyframe);
}

void MapServerNode::on_features(const features_t& message) {
  for (const KeyframeFeatures::Found& found : keyframe_features_.features(message)) remember(found);
}

/// A keyframe has its features.
void MapServerNode::remember(const KeyframeFeatures::Found& found) {
  const auto& [key, id, utime] = found.keyframe;
  if (recorder_) recorder_->features(key, id, found.features);
  const auto* session = dense_maps_.find(key);
  if (!places_ || !is_current(key) || session == nullptr) return;
  const auto keyframe = session->map.keyframes().find(id);
  if (keyframe != session->map.keyframes().end())
    places_->keyframe(id, keyframe->second.T_world_camera, found.features, keyframe->second.cloud);
}

void MapServerNode::begin_places(const SessionKey& key) {
  if (places_) places_->begin_session(recorder_ ? recorder_->stored("icp", key) : 0);
}

void MapServerNode::derive_from(const SessionKey& key, const DenseKeyframe& keyframe) {
  auto images = layers_->keyframe(
      keyframe, [&] { return recorder_ ? recorder_->kept_images(key, keyframe.id) : std::nullopt; });
  if (recorder_ && images) recorder_->images(key, keyframe.id, std::move(*images));
}

void MapServerNode::on_graph(const graph_t& message) {
  from_message(message);  // throws before anything is kept beside
  auto* session = &session_of(dense_maps_, message);
  if (2 * kept_by(message, session->map) < session->map.keyframes().size()) {
    if (!dense_maps_.keep_beside(key_of(message), session->map))
      refuse("it takes away the most of a map, and there is no room to keep that beside");
    const auto& kept = dense_maps_.all().back();
    if (recorder_) recorder_->kept_beside(kept.key, kept.map);
  }
  session = dense_maps_.find(key_of(message));
  session->graph.apply(message);
  lcmslam::follow(session->map, session->graph, message);
  ++changes_;
  if (recorder_) recorder_->graph(session->key, message, session->graph, session->map);
  if (!is_current(session->key)) return;
  if (layers_) layers_->correct(session->map);
  if (!places_) return;
  std::map<std::int32_t, Eigen::Isometry3d> moved;
  for (const graph_node_t& told : message.nodes)
    if (const auto keyframe = session->map.keyframes().find(told.keyframe);
        keyframe != session->map.keyframes().end())
      moved[keyframe->first] = keyframe->second.T_world_camera;
  std::vector<std::int32_t> gone;
  for (const std::int32_t id : message.gone)
    if (session->map.keyframes().count(id) == 0) gone.push_back(id);
  places_->correct(moved, gone);
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

MapsToSave MapServerNode::maps_to_save(bool with_kept) const {
  MapsToSave maps;
  maps.resolution = resolution_;
  if (layers_) maps.live = layers_->map();
  maps.T_map_robot = T_map_robot_;
  if (recorder_ && with_kept) {
    maps.store = recorder_->file();
    maps.kept = recorder_->kept();
  }
  const auto before = [&](const char* mapper) { return recorder_ ? recorder_->kept(mapper) : 0; };
  // The current session of each mapper has the plain name, the others carry a number.
  for (std::size_t i = 0; i < landmark_maps_.size(); ++i)
    maps.landmarks.push_back({landmark_maps_.name("fastslam", i, before("fastslam")),
                              landmark_maps_.all()[i].map.landmarks(),
                              i == landmark_maps_.current() ? fastslam_path_ : Path()});
  for (std::size_t i = 0; i < dense_maps_.size(); ++i)
    maps.dense.push_back({dense_maps_.name("icp", i, before("icp")), dense_maps_.all()[i].map,
                          i == dense_maps_.current() ? icp_path_ : Path(), i == dense_maps_.current()});
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
  saver_.begin(maps_to_save(false), folder(), saved_changes_);
}

std::optional<Node::Duration> MapServerNode::work() {
  note_saving(false);
  note_store();
  note_joined();
  show_kept();
  for (const QuestionDesk::Answered& answered : desk_.take()) {
    if (answered.error.empty()) ++answered_;
    replies_.add(answered);
  }
  replies_.send(publisher_);
  const auto now = std::chrono::steady_clock::now();
  // A map that has grown large is saved less often, so that saving takes no more of the time; its file is up
  // to date all the while.
  const auto pause = std::max(std::chrono::duration<double>(snapshot_period_), saving_pause * saving_took_);
  if (snapshot_period_ > 0 && now - last_snapshot_ >= pause) {
    last_snapshot_ = now;
    save_beside();
  }
  if (!desk_.busy() && replies_.empty()) return std::nullopt;
  return std::chrono::milliseconds(1);
}

/// What changed since it was saved is copied here and written by another thread.
void MapServerNode::save_beside() {
  note_saving(false);
  if (changes_ != saved_changes_ && !saver_.busy()) saver_.begin(maps_to_save(false), folder_, changes_);
}

void MapServerNode::note_saving(bool wait) {
  const auto outcome = saver_.take_outcome(wait);
  if (!outcome) return;
  failure_ = outcome->error;
  saving_took_ = outcome->took;
  if (!failure_.empty()) return spdlog::error("maps are not saved: {}", failure_);
  saved_changes_ = outcome->revision;
  ++saved_;
  spdlog::info("maps saved in {}", folder_.string());
}

/// Pictures too: drawing them takes too long while a run goes on.
void MapServerNode::finish() {
  note_saving(true);
  if (layers_) layers_->settle(longest_settling);
  if (changes_ != saved_changes_ || changes_ != drawn_changes_)
    saver_.begin(maps_to_save(true), folder_, changes_, "");
  note_saving(true);
  if (recorder_) recorder_->flush();
  note_store();
  finished_ = true;
}

/// Sessions whose place in the file's map was found.
void MapServerNode::note_joined() {
  if (!places_) return;
  for (const auto& joined : places_->take_joined()) note_joined("icp", joined, dense_maps_);
  for (const auto& joined : landmark_places_->take_joined()) note_joined("fastslam", joined, landmark_maps_);
}

template <class Map>
void MapServerNode::note_joined(const std::string& mapper, const SessionPlaces::Joined& joined,
                                SessionTable<Map>& sessions) {
  joined_[mapper] += !joined.again;
  const Eigen::Vector3d at = joined.joint.T_map_session.translation();
  const std::string said = to_string(joined.joint);
  spdlog::info("{}: {} lies at {:.2f} {:.2f} {:.2f} m, {:.1f} deg in the map: {}", mapper,
               joined.stored == 0 ? "this session" : fmt::format("session {} of the file", joined.stored),
               at.x(), at.y(), at.z(), yaw(joined.joint.T_map_session) * 180 / M_PI, said);
  if (joined.stored != 0) {
    if (recorder_) recorder_->place(joined.stored, joined.joint);
  } else if (!sessions.empty()) {
    const SessionKey key = sessions.all()[sessions.current()].key;
    sessions.find(key)->evidence = said;
    if (recorder_) recorder_->place(mapper, key, joined.joint);
  }
}

/// What the file's map has is shown to derived maps beside what is new, when those have nothing to do.
void MapServerNode::show_kept() {
  if (!places_ || !layers_ || !layers_->calibration() || layers_->state().waiting > 2) return;
  if (auto kept = places_->next_kept())
    layers_->adopt(first_kept_id + kept->number, kept->T_session_camera, kept->images,
                   kept->cloud.value_or(ColouredCloud()));
}

/// Once when it begins and once when it is over: STATUS says it all the time.
void MapServerNode::note_store() {
  if (!recorder_) return;
  const std::string error = recorder_->error();
  if (error == store_failure_) return;
  if (error.empty())
    spdlog::info("the map's file is written again: {}", recorder_->file().string());
  else
    spdlog::error("the map's file is not written, mapping goes on: {}", error);
  store_failure_ = error;
}

}  // namespace lcmslam
