// What the map server tells of itself: STATUS, and what the live page shows.

#include <algorithm>

#include <lcmslam/status_t.hpp>
#include "procs/map-server/map_server_node.hpp"

namespace lcmslam {

MapServerNode::Shown MapServerNode::shown() const {
  Shown shown;
  if (!dense_maps_.empty()) {
    const auto& session = dense_maps_.all()[dense_maps_.current()];
    shown.map = session.key;
    shown.dense = &session.map;
    shown.graph = &session.graph;
  } else if (!landmark_maps_.empty()) {
    shown.map = landmark_maps_.all()[landmark_maps_.current()].key;
  }
  shown.landmarks = landmark_maps_.current_map();
  if (icp_pose_) shown.icp_pose = &*icp_pose_;
  if (fastslam_pose_) shown.fastslam_pose = &*fastslam_pose_;
  shown.icp_path = &icp_path_;
  shown.fastslam_path = &fastslam_path_;
  if (layers_) shown.live = layers_->map();
  return shown;
}

template <class Map>
std::optional<std::string> MapServerNode::evidence(const std::string& mapper,
                                                   const SessionTable<Map>& sessions,
                                                   std::size_t index) const {
  const auto& session = sessions.all()[index];
  if (!session.evidence.empty()) return session.evidence;
  const std::int64_t stored = recorder_ ? recorder_->goes_on(mapper, session.key) : 0;
  if (stored != 0) return recorder_->evidence(stored);
  const bool is_first =
      index == 0 && !localises_ && (!recorder_ || (recorder_->is_read() && recorder_->kept(mapper) == 0));
  return is_first ? std::optional<std::string>("") : std::nullopt;
}

std::vector<MapServerNode::ToldSession> MapServerNode::told_sessions() const {
  std::vector<ToldSession> told;
  if (recorder_)
    for (const KeptSession& kept : recorder_->kept()) {
      told.push_back({kept.name, kept.mapper, kept.begin, kept.end});
      told.back().is_kept = true;
      told.back().keyframes = static_cast<std::size_t>(kept.keyframes);
      told.back().landmarks = static_cast<std::size_t>(kept.landmarks);
      told.back().joined = recorder_->evidence(kept.id);
    }
  const auto before = [&](const char* mapper) { return recorder_ ? recorder_->kept(mapper) : 0; };
  for (std::size_t i = 0; i < dense_maps_.size(); ++i) {
    const auto& keyframes = dense_maps_.all()[i].map.keyframes();
    ToldSession session{dense_maps_.name("icp", i, before("icp")), "icp"};
    session.is_current = i == dense_maps_.current();
    session.keyframes = keyframes.size();
    session.joined = evidence("icp", dense_maps_, i);
    for (const auto& [id, keyframe] : keyframes) {
      session.begin = session.begin == 0 ? keyframe.utime : std::min(session.begin, keyframe.utime);
      session.end = std::max(session.end, keyframe.utime);
    }
    told.push_back(session);
  }
  for (std::size_t i = 0; i < landmark_maps_.size(); ++i) {
    ToldSession session{landmark_maps_.name("fastslam", i, before("fastslam")), "fastslam"};
    session.is_current = i == landmark_maps_.current();
    session.landmarks = landmark_maps_.all()[i].map.size();
    session.joined = evidence("fastslam", landmark_maps_, i);
    told.push_back(session);
  }
  return told;
}

std::shared_ptr<const EncodedFrame> MapServerNode::image_at(Utime colour_time) const {
  return layers_ ? layers_->image_at(colour_time) : nullptr;
}

std::shared_ptr<const EncodedFrame> MapServerNode::newest_image() const {
  const auto image = layers_ ? layers_->newest_image() : nullptr;
  return image ? image : picture_;
}

/// What of the old file cannot be read; the rest is there, and what comes is written.
std::string MapServerNode::damage() const {
  if (recorder_ && (!recorder_->is_read() || !recorder_->damage().empty())) return recorder_->damage();
  if (!places_) return "";
  const std::string error = places_->error();
  return error.empty() ? landmark_places_->error() : error;
}

NodeReport MapServerNode::report() const {
  NodeReport report;
  report.refused = requests_refused_;
  if (!failure_.empty()) report.detail = "maps are not saved: " + failure_;
  if (!failure_.empty() && changes_ != saved_changes_) report.state = status_t::FAILED;
  if (!overwritten_.empty()) report.detail += (report.detail.empty() ? "" : "; ") + overwritten_;
  const std::string unwritten = recorder_ ? recorder_->error() : "";
  if (!unwritten.empty()) {
    report.detail += (report.detail.empty() ? "" : "; ") + ("the map's file is not written: " + unwritten);
    if (finished_) report.state = status_t::FAILED;
  }
  if (const std::string damage = this->damage(); !damage.empty())
    report.detail += (report.detail.empty() ? "" : "; ") + ("the map's file cannot be read: " + damage);
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
                   {"requests_refused", number(requests_refused_)},
                   {"questions_answered", number(answered_)}};
  if (layers_) {
    const LayerWorker::State layers = layers_->state();
    report.values.emplace_back("layer_frames", number(layers.shown));
    report.values.emplace_back("layer_keyframes", number(layers.kept));
    report.values.emplace_back("layer_imageless", number(layers.imageless));
    report.values.emplace_back("layer_left_out", number(layers.left_out));
    report.values.emplace_back("layer_failed", number(layers.failed));
    if (const auto live = layers_->map())
      report.values.emplace_back("layer_memory_mb", 1e-6 * number(live->memory_bytes()));
    if (!layers.error.empty()) report.detail += (report.detail.empty() ? "" : "; ") + layers.error;
  }
  if (places_) {
    report.values.emplace_back("places", number(places_->current_keyframes()));
    report.values.emplace_back("kept_keyframes", number(places_->kept_keyframes()));
    const auto joined = [&](const char* mapper) {
      const auto count = joined_.find(mapper);
      return count != joined_.end() ? number(count->second) : 0;
    };
    report.values.emplace_back("sessions_joined", joined("icp"));
    report.values.emplace_back("kept_landmarks", number(landmark_places_->kept_landmarks()));
    report.values.emplace_back("landmark_sessions_joined", joined("fastslam"));
  }
  if (recorder_) {
    const StoreWriter::State store = recorder_->state();
    report.values.emplace_back("kept_sessions", number(recorder_->kept().size()));
    report.values.emplace_back("store_commits", number(store.commits));
    report.values.emplace_back("store_failures", number(store.failures));
    report.values.emplace_back("store_restored", number(store.restored));
  }
  return report;
}

}  // namespace lcmslam
