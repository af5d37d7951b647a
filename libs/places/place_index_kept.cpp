// Which keyframes a place is found by: they come, move, make room and go.

#include <algorithm>

#include <lcmslam/places/place_index.hpp>

namespace lcmslam {

void PlaceIndex::take_over(const PlaceIndex& other, const Eigen::Isometry3d& T_map_other,
                           std::int64_t first_key) {
  for (const auto& [key, view] : other.views_)
    add(first_key + key, View{T_map_other * view.T_map_camera, view.features, view.cloud, {}, 0});
}

void PlaceIndex::add(std::int64_t key, View view) {
  drop(key);
  view.cloud.points.shrink_to_fit();
  view.cloud.normals.shrink_to_fit();
  for (const Feature& feature : view.features.features) {
    int slot = static_cast<int>(key_of_slot_.size());
    if (free_slots_.empty()) {
      key_of_slot_.push_back(key);
    } else {
      slot = free_slots_.back();
      free_slots_.pop_back();
      key_of_slot_[static_cast<std::size_t>(slot)] = key;
    }
    index_.insert(slot, feature.descriptor, feature.laplacian);
    view.slots.push_back(slot);
  }
  view.number = ++added_;
  const Eigen::Isometry3d T_map_camera = view.T_map_camera;
  views_[key] = std::move(view);
  thin_around(T_map_camera);
}

void PlaceIndex::thin_around(const Eigen::Isometry3d& T_map_camera) {
  std::vector<std::pair<std::int64_t, std::int64_t>> near;  // number and key
  for (const auto& [key, view] : views_)
    if (distance_between(view.T_map_camera, T_map_camera) < settings_.same_view_distance &&
        angle_between(view.T_map_camera, T_map_camera) < settings_.same_view_angle)
      near.emplace_back(view.number, key);
  const auto most = static_cast<std::size_t>(settings_.visits);
  if (near.size() <= most) return;
  std::sort(near.begin(), near.end());
  drop(near[most / 2].second);
}

void PlaceIndex::move(std::int64_t key, const Eigen::Isometry3d& T_map_camera) {
  const auto view = views_.find(key);
  if (view != views_.end()) view->second.T_map_camera = T_map_camera;
}

void PlaceIndex::drop(std::int64_t key) {
  const auto view = views_.find(key);
  if (view == views_.end()) return;
  for (const int slot : view->second.slots) {
    index_.remove(slot);
    free_slots_.push_back(slot);
  }
  views_.erase(view);
}

std::vector<std::int64_t> PlaceIndex::keys(std::int64_t first, std::int64_t end) const {
  std::vector<std::int64_t> keys;
  for (auto view = views_.lower_bound(first); view != views_.end() && view->first < end; ++view)
    keys.push_back(view->first);
  return keys;
}

std::size_t PlaceIndex::memory_bytes() const {
  std::size_t bytes = index_.memory_bytes() + key_of_slot_.capacity() * sizeof key_of_slot_[0];
  for (const auto& [key, view] : views_)
    bytes += sizeof view + lcmslam::memory_bytes(view.cloud) +
             view.features.features.capacity() * sizeof(Feature) + view.slots.capacity() * sizeof(int);
  return bytes;
}

}  // namespace lcmslam
