#include <lcmslam/live_page/shown_map.hpp>

#include <fmt/format.h>

#include <lcmslam/live_page/show_on_board.hpp>

namespace lcmslam {

bool ShownMap::clouds(const DenseMap& map, std::size_t most_points) {
  forget_gone(map);
  std::size_t points = 0;
  for (auto k = map.keyframes().rbegin(); k != map.keyframes().rend(); ++k) {
    const auto& [id, keyframe] = *k;
    const auto known = clouds_.find(id);
    if (known != clouds_.end() && known->second == keyframe.revision) continue;
    if (points > 0 && points + keyframe.cloud.size() > most_points) return false;
    points += keyframe.cloud.size();
    clouds_[id] = keyframe.revision;
    for (PageItem& item : points_items(keyframe)) show_on(board_, std::move(item));
  }
  return true;
}

void ShownMap::forget_gone(const DenseMap& map) {
  for (auto known = clouds_.begin(); known != clouds_.end();) {
    if (map.keyframes().count(known->first) > 0) {
      ++known;
      continue;
    }
    for (int level = 0; level < point_levels; ++level)
      board_.remove("points", fmt::format("{}/{}", known->first, level));
    known = clouds_.erase(known);
  }
}

void ShownMap::graph(const std::vector<KeyframePose>& nodes, const std::vector<PageEdge>& edges) {
  show_on(board_, graph_item(nodes, edges));
}

void ShownMap::landmarks(std::vector<Landmark> landmarks) {
  show_all_on(board_, "landmarks", landmark_items(std::move(landmarks)));
}

void ShownMap::paths(const std::map<std::string, std::vector<const Path*>>& paths) {
  std::vector<PageItem> items;
  for (const auto& [name, lines] : paths) {
    std::size_t number = 0;
    for (const Path* path : lines) {
      if (path == nullptr) continue;
      for (PageItem& item : path_items(name, *path, number)) {
        items.push_back(std::move(item));
        ++number;
      }
      ++number;  // one that is left out: the page joins neighbours
    }
  }
  show_all_on(board_, "path", std::move(items));
}

void ShownMap::forget() {
  for (const char* channel : {"points", "graph", "landmarks", "path"}) board_.remove(channel);
  clouds_.clear();
}

}  // namespace lcmslam
