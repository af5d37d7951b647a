#include "procs/map-server/map_server_node.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

// Ids of the file's keyframes among those of the derived maps; mappers' own begin at 0.
constexpr int first_kept_id = 1'000'000'000;

constexpr std::chrono::seconds reading_pause(1);

constexpr int saving_pause = 50;  // times as long as a saving took, until the next

std::size_t size(int setting) {
  return static_cast<std::size_t>(setting);
}

/// A line a setting; without the page's, which make no map and may hold a token.
std::string text_of(MapServerSettings settings) {
  settings.page = {};
  std::string text;
  for (const SettingEntry& entry : list_settings(settings)) text += entry.path + ": " + entry.value + "\n";
  return text;
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
      configuration_(text_of(settings)),
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
  if (!localises_ && !store.empty()) recorder_.emplace(store, configuration_);
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

void MapServerNode::command(const command_t& command) {
  if (command.name == "save") save_beside();
  keep_what_is_reset(command);
}

std::optional<Node::Duration> MapServerNode::work() {
  note_saving(false);
  begin_export();
  if (std::chrono::steady_clock::now() >= next_reading_) read_again(std::chrono::milliseconds(0));
  note_store();
  note_joined();
  retire("icp", dense_maps_);
  retire("fastslam", landmark_maps_);
  show_late();
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
  if (desk_.busy() || !replies_.empty()) return std::chrono::milliseconds(1);
  if (exporting_ || !resets_.empty()) return std::chrono::milliseconds(10);
  return std::nullopt;
}

/// The old file, where somebody held it or the disk was full when this server began.
void MapServerNode::read_again(std::chrono::milliseconds patience) {
  next_reading_ = std::chrono::steady_clock::now() + reading_pause;
  const bool was_read = recorder_ && recorder_->read_again(patience);
  if (places_ && (!recorder_ || recorder_->is_read())) {
    const std::int64_t newest = recorder_ ? recorder_->newest_of_before() : SessionPlaces::all_sessions;
    places_->read_again(newest);
    landmark_places_->read_again(newest);
  }
  if (was_read) go_on_with_stored();
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

/// A map that its mapper has left needs no memory once it is in the file.
template <class Map>
void MapServerNode::retire(const std::string& mapper, SessionTable<Map>& sessions) {
  while (recorder_ && !sessions.empty() && sessions.current() != 0) {
    const auto stored = recorder_->retire(mapper, sessions.all().front().key);
    if (!stored) return;
    sessions.drop_first();
    if (places_ && mapper == "icp") places_->keep(*stored);
  }
}

/// Keyframes for which there was no time, and what the file's map has, are shown to derived maps when those
/// have nothing else to do.
void MapServerNode::show_late() {
  if (!layers_ || !layers_->calibration() || layers_->state().waiting > 2) return;
  if (!late_.empty() && !dense_maps_.empty()) {
    const auto& session = dense_maps_.all()[dense_maps_.current()];
    const auto found = session.map.keyframes().find(*late_.begin());
    late_.erase(late_.begin());
    if (found != session.map.keyframes().end()) derive_from(session.key, found->second);
    return;
  }
  if (!places_) return;
  std::map<int, Eigen::Isometry3d> moved;
  for (const auto& [number, T] : places_->moved_kept()) moved[first_kept_id + number] = T;
  if (!moved.empty()) layers_->move_adopted(std::move(moved));
  if (auto kept = places_->next_kept())
    layers_->adopt(first_kept_id + kept->number, kept->T_session_camera, kept->images,
                   kept->cloud.value_or(ColouredCloud()));
}

}  // namespace lcmslam
