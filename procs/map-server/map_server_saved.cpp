// When and what the map server writes: snapshots beside the run, at its end, before a reset.

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <lcmslam/runtime/confirmation.hpp>
#include "procs/map-server/map_server_node.hpp"

namespace lcmslam {
namespace {

constexpr auto longest_settling = std::chrono::seconds(4);

}  // namespace

MapsToSave MapServerNode::maps_to_save(bool with_kept) const {
  MapsToSave maps;
  maps.resolution = resolution_;
  if (layers_) maps.live = layers_->map();
  maps.T_map_robot = T_map_robot_;
  if (layers_ && layers_->calibration() && !dense_maps_.empty()) {
    const Eigen::Isometry3d T_camera_robot = layers_->calibration()->T_robot_camera.inverse();
    for (const auto& [id, keyframe] : dense_maps_.all()[dense_maps_.current()].map.keyframes())
      maps.also_stood.emplace_back((keyframe.T_world_camera * T_camera_robot).translation());
  }
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

/// A mapper is told to forget its map: as it is now it stays on disk, in a folder of its own.
void MapServerNode::keep_what_is_reset(const command_t& command) {
  const auto forgets = [&](const char* process, const auto& sessions) {
    return !sessions.empty() && is_confirmed(command, process, sessions.all()[sessions.current()].key.sender);
  };
  if (command.name != "reset" || !(forgets("fastslam", landmark_maps_) || forgets("icp", dense_maps_)))
    return;
  std::filesystem::path folder;
  do folder = folder_ / fmt::format("before-reset-{}", ++reset_number_);
  while (std::filesystem::exists(folder));
  spdlog::info("reset: the maps so far are kept in {}", folder.string());
  resets_.push_back({maps_to_save(false), folder});
  note_saving(false);
  begin_export();
}

/// What changed since it was saved is copied here and written by another thread.
void MapServerNode::save_beside() {
  note_saving(false);
  if (changes_ != saved_changes_ && !saver_.busy()) saver_.begin(maps_to_save(false), folder_, changes_);
}

void MapServerNode::note_saving(bool wait) {
  const auto outcome = saver_.take_outcome(wait);
  if (!outcome) return;
  if (const auto ended = std::exchange(exporting_, std::nullopt)) {
    const bool all = ended->request.argument.empty() && ended->request.format.empty();
    if (all && outcome->error.empty()) drawn_changes_ = outcome->revision;
    return ended->done(outcome->files, outcome->error);
  }
  failure_ = outcome->error;
  saving_took_ = outcome->took;
  if (!failure_.empty()) return spdlog::error("maps are not saved: {}", failure_);
  saved_changes_ = outcome->revision;
  ++saved_;
  spdlog::info("maps saved in {}", folder_.string());
}

/// Pictures too: drawing them takes too long while a run goes on.
void MapServerNode::finish() {
  read_again(Database::usual_patience);
  note_saving(true);
  for (begin_export(); saver_.busy(); begin_export()) note_saving(true);
  if (layers_) layers_->settle(longest_settling);
  if (changes_ != saved_changes_ || changes_ != drawn_changes_)
    saver_.begin(maps_to_save(true), folder_, changes_, "");
  note_saving(true);
  if (recorder_) recorder_->flush();
  note_store();
  if (recorder_ && !overwritten_.empty()) recorder_->flush();  // it may have been noticed just now
  note_store();
  finished_ = true;
}

/// Another file was written over the map's. That stays as it is, and what is in memory goes into a new one.
void MapServerNode::begin_file_beside() {
  const std::filesystem::path lost = recorder_->file();
  std::filesystem::path file;
  int number = 2;
  do
    file = lost.parent_path() /
           fmt::format("{}-{}{}", lost.stem().string(), number++, lost.extension().string());
  while (may_be_there(file));
  overwritten_ = fmt::format("another file was written over {}: this run's map goes on in {}", lost.string(),
                             file.filename().string());
  spdlog::error("{}", overwritten_);
  recorder_.emplace(file, configuration_);
  record_all();
  if (stored_calibration_) recorder_->calibration(calibration_message_);
  if (!places_) return;
  places_->begin_file(file);
  landmark_places_->begin_file(file);
}

/// Once when it begins and once when it is over: STATUS says it all the time.
void MapServerNode::note_store() {
  if (!recorder_) return;
  if (recorder_->state().overwritten) begin_file_beside();
  const std::string damage = recorder_->damage();
  if (!damage.empty() && damage != damage_) spdlog::warn("the map's file cannot be read: {}", damage);
  damage_ = damage;
  const std::int64_t restored = recorder_->state().restored;
  if (restored != std::exchange(restored_, restored))
    spdlog::warn("the map's file had been taken away, and was written again: {}", recorder_->file().string());
  const std::string error = recorder_->error();
  if (error == store_failure_) return;
  if (error.empty())
    spdlog::info("the map's file is written again: {}", recorder_->file().string());
  else
    spdlog::error("the map's file is not written, mapping goes on: {}", error);
  store_failure_ = error;
}

}  // namespace lcmslam
