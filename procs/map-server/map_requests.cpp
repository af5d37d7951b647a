// What the map server answers to MAP_REQUEST.

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "procs/map-server/map_server_node.hpp"

namespace lcmslam {

namespace {

constexpr std::size_t most_exports = 16;  // that wait

map_reply_t reply_to(const map_request_t& request) {
  map_reply_t reply{};
  reply.utime = request.utime;
  reply.request_id = request.request_id;
  reply.n_tiles = 1;
  return reply;
}

/// Whether layers answer it, and not the maps as mappers tell them.
bool is_derived(const Question& question) {
  return !std::holds_alternative<CloudQuestion>(question.what) &&
         !std::holds_alternative<LandmarksQuestion>(question.what) &&
         !std::holds_alternative<LocaliseQuestion>(question.what);
}

}  // namespace

void MapServerNode::on_request(const map_request_t& request) {
  map_reply_t reply = reply_to(request);
  try {
    if (request.kind == map_request_t::QUERY) return ask(request);
    if (request.kind == map_request_t::EXPORT) return answer_export(request);
    if (request.kind != map_request_t::INFO)
      throw std::runtime_error(fmt::format("there is no request of kind {}", request.kind));
    const std::string info = describe();
    reply.content = "application/json";
    reply.data.assign(info.begin(), info.end());
    reply.size = static_cast<std::int32_t>(reply.data.size());
  } catch (const std::exception& error) {
    refuse_request(reply, error.what());
  }
  publisher_.publish("MAP_REPLY", reply);
}

void MapServerNode::refuse_request(map_reply_t& reply, const std::string& why) {
  reply.status = 1;
  reply.message = why;
  ++requests_refused_;
  spdlog::error("request refused: {}", why);
}

/// Answered by work(), when the desk has done its part.
void MapServerNode::ask(const map_request_t& request) {
  if (desk_.has(request)) return;
  Question question = parse_question(request.argument);
  if (!layers_ && is_derived(question))
    throw std::runtime_error("nothing is derived from the map here: map-server.layers.make is false");
  // Before the map is copied for it.
  if (replies_.full() || desk_.is_full_for(question))
    throw std::runtime_error("too many questions wait for an answer");
  AskedMap map = asked_map(question);
  if (!desk_.ask({request, std::move(question), std::move(map)}))
    throw std::runtime_error("too many questions wait for an answer");
}

AskedMap MapServerNode::asked_map(const Question& question) const {
  AskedMap map;
  map.changes = changes_;
  if (layers_) map.live = layers_->map();
  map.T_map_robot = T_map_robot_;
  if (!dense_maps_.empty()) map.frame = dense_maps_.all()[dense_maps_.current()].key.frame;
  if (const auto* cloud = std::get_if<CloudQuestion>(&question.what)) map.cloud = points_in(cloud->region);
  if (const auto* q = std::get_if<LandmarksQuestion>(&question.what);
      q != nullptr && !landmark_maps_.empty()) {
    const auto& session = landmark_maps_.all()[landmark_maps_.current()];
    map.frame = session.key.frame;
    for (const Landmark& landmark : session.map.landmarks())
      if (q->region.contains(landmark.mean)) map.landmarks.push_back(landmark);
  }
  if (const auto* q = std::get_if<LocaliseQuestion>(&question.what); q != nullptr && places_) {
    const auto features = keyframe_features_.at(q->utime);
    if (!features) throw std::runtime_error("no FEATURES of that time have come, or they are gone");
    map.locate = [places = places_.get(), features = *features, frame = map.frame] {
      SessionPlaces::Answer answer = places->locate(features);
      AskedMap::Found found{std::move(answer.located), answer.in_current ? frame : "the file's map", {}};
      if (features.has_mount) found.T_robot_camera = features.T_robot_camera;
      return found;
    };
  }
  return map;
}

ColouredCloud MapServerNode::points_in(const Region& region) const {
  ColouredCloud inside;
  const DenseMap* map = dense_maps_.current_map();
  if (map == nullptr) throw std::runtime_error("no keyframe has come yet (icp makes them)");
  for (const auto& [id, keyframe] : map->keyframes()) {
    const Eigen::Isometry3d& T = keyframe.T_world_camera;
    const bool has_normals = keyframe.cloud.normals.size() == keyframe.cloud.size();
    for (std::size_t i = 0; i < keyframe.cloud.size(); ++i) {
      const Eigen::Vector3d point = T * keyframe.cloud.points[i].cast<double>();
      if (!region.contains(point)) continue;
      inside.points.emplace_back(point.cast<float>());
      inside.colours.push_back(keyframe.cloud.colours[i]);
      if (has_normals) inside.normals.emplace_back(T.linear().cast<float>() * keyframe.cloud.normals[i]);
    }
  }
  if (inside.normals.size() != inside.size()) inside.normals.clear();
  return inside;
}

std::string MapServerNode::describe() const {
  const LandmarkMap* landmarks = landmark_maps_.current_map();
  const DenseMap* dense = dense_maps_.current_map();
  return fmt::format(
      R"({{"landmarks": {}, "keyframes": {}, "map_points": {}, "resolution": {}, "kept_sessions": {}}})",
      landmarks != nullptr ? landmarks->size() : 0, dense != nullptr ? dense->keyframes().size() : 0,
      dense != nullptr ? dense->point_count() : 0, resolution_, recorder_ ? recorder_->kept().size() : 0);
}

void MapServerNode::answer_export(const map_request_t& request) {
  export_maps(request, [this, request](const std::vector<std::string>& files, const std::string& error) {
    map_reply_t reply = reply_to(request);
    for (const std::string& file : files) reply.message += file + "\n";
    if (!error.empty()) refuse_request(reply, error);
    publisher_.publish("MAP_REPLY", reply);
  });
}

void MapServerNode::export_maps(const map_request_t& request, Exported done) {
  if (exports_.size() >= most_exports) throw std::runtime_error("too many exports wait");
  exports_.push_back({request, export_folder(request.argument), std::move(done)});
  begin_export();
}

/// One at a time, and not beside a snapshot: both write files of the same names. What a reset leaves comes
/// first.
void MapServerNode::begin_export() {
  if (saver_.busy()) return;
  if (!resets_.empty()) {
    saver_.begin(std::move(resets_.front().maps), resets_.front().folder, saved_changes_);
    return resets_.pop_front();
  }
  if (exports_.empty()) return;
  exporting_ = std::move(exports_.front());
  exports_.pop_front();
  saver_.begin(maps_to_save(true), exporting_->folder, changes_, exporting_->request.format);
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

}  // namespace lcmslam
