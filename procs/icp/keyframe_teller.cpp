#include "procs/icp/keyframe_teller.hpp"

#include <algorithm>
#include <set>
#include <thread>

#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>

namespace lcmslam {
namespace {

int id_of(const DenseMapper& mapper, const DenseMapper::Keyframe& keyframe) {
  return mapper.graph().nodes()[static_cast<std::size_t>(keyframe.node)].id;
}

}  // namespace

void KeyframeTeller::tell(const Map& map, const Keyframe& keyframe) {
  told_[id_of(map.mapper, keyframe)] = {++revisions_, keyframe.cloud.size()};
  queue(map, keyframe, revisions_);
}

void KeyframeTeller::tell_changed(const Map& map, bool all) {
  for (const std::size_t i : map.mapper.take_changed(all)) tell(map, map.mapper.keyframes()[i]);
}

// A cloud that was told as it is keeps its revision: whoever has it knows it again. The newest one still
// grows.
void KeyframeTeller::tell_all(const Map& map) {
  if (!tiles_.empty()) return;
  const auto& keyframes = map.mapper.keyframes();
  const std::vector<std::size_t> changed = map.mapper.take_changed(true);
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const auto told = told_.find(id_of(map.mapper, keyframes[i]));
    const bool is_as_told = told != told_.end() && i + 1 < keyframes.size() &&
                            told->second.points == keyframes[i].cloud.size() &&
                            std::find(changed.begin(), changed.end(), i) == changed.end();
    if (is_as_told)
      queue(map, keyframes[i], told->second.revision);
    else
      tell(map, keyframes[i]);
  }
}

void KeyframeTeller::queue(const Map& map, const Keyframe& keyframe, std::int64_t revision) {
  const DenseKeyframe dense{id_of(map.mapper, keyframe), keyframe.utime, keyframe.T_world_camera,
                            keyframe.cloud};
  for (auto& tile : make_keyframe_tiles(dense, map.T_robot_camera, revision)) {
    tile.frame = map.frame;
    tiles_.push_back(std::move(tile));
  }
}

// A keyframe goes out where the graph has it by then: whoever hears it takes its pose for the newest.
void KeyframeTeller::move(const Map& map) {
  std::map<std::int32_t, rigid_transform_t> poses;
  for (const Keyframe& keyframe : map.mapper.keyframes())
    poses[id_of(map.mapper, keyframe)] = to_message(keyframe.T_world_camera);
  for (keyframe_t& tile : tiles_)
    if (const auto pose = poses.find(tile.id); tile.frame == map.frame && pose != poses.end())
      tile.T_map_camera = pose->second;
}

void KeyframeTeller::drop_the_gone(const Map& map) {
  std::set<std::int32_t> ids;
  for (const auto& node : map.mapper.graph().nodes()) ids.insert(node.id);
  const auto is_gone = [&](const keyframe_t& tile) {
    return tile.frame == map.frame && ids.count(tile.id) == 0;
  };
  tiles_.erase(std::remove_if(tiles_.begin(), tiles_.end(), is_gone), tiles_.end());
  for (auto told = told_.begin(); told != told_.end();)
    told = ids.count(told->first) == 0 ? told_.erase(told) : std::next(told);
}

void KeyframeTeller::publish_next() {
  publisher_.publish("ICP_KEYFRAME", tiles_.front());
  tiles_.pop_front();
}

std::optional<Node::Duration> KeyframeTeller::work() {
  const auto pace = publisher_.pace();
  while (!tiles_.empty() && pace.count() == 0) publish_next();
  if (tiles_.empty()) return std::nullopt;
  const auto now = std::chrono::steady_clock::now();
  if (now >= next_) {
    publish_next();
    next_ = now + pace;
  }
  return pace;
}

void KeyframeTeller::finish() {
  while (!tiles_.empty()) {
    publish_next();
    std::this_thread::sleep_for(publisher_.pace());
  }
}

}  // namespace lcmslam
