#include <lcmslam/fastslam/landmarks/landmark_grid.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {

void LandmarkGrid::follow(const ParticleMap& map, const LandmarkIndex& index) {
  places_.resize(std::max(places_.size(), static_cast<std::size_t>(index.slots())));
  ParticleMap::for_each_difference(
      followed_, map, [&](std::size_t slot, const CompactLandmark* before, const CompactLandmark& now) {
        if (slot >= places_.size() || (before && before->mean == now.mean)) return;
        const int number = static_cast<int>(slot);
        if (number < index.slots() && index.alive(number) && index.record(number).known_id < 0)
          put(slot, now.mean);
        else
          remove(slot);
      });
  followed_ = map;
}

LandmarkGrid::Key LandmarkGrid::key_of(const Eigen::Vector3d& mean) {
  const auto digit = [](double x) {
    return static_cast<int>(std::floor(std::clamp(x / cell_size, -1e6, 1e6)));
  };
  return {digit(mean.x()), digit(mean.y()), digit(mean.z())};
}

void LandmarkGrid::remove(std::size_t slot) {
  Place& place = places_[slot];
  if (!place.cell) return;
  Entry& gap = (*place.cell)[place.position];
  gap = place.cell->back();
  places_[static_cast<std::size_t>(gap.slot)].position = place.position;
  place.cell->pop_back();
  place = {};
}

void LandmarkGrid::put(std::size_t slot, const Eigen::Vector3d& mean) {
  const Place& place = places_[slot];
  const Key key = key_of(mean);
  if (place.cell && place.key == key) {  // as nearly always
    (*place.cell)[place.position].mean = mean;
    return;
  }
  remove(slot);
  std::vector<Entry>& entries = cell(key);
  places_[slot] = {&entries, entries.size(), key};
  entries.push_back({static_cast<int>(slot), mean});
}

std::vector<LandmarkGrid::Entry>& LandmarkGrid::cell(const Key& key) {
  auto found = std::lower_bound(cells_.begin(), cells_.end(), key,
                                [](const Cell& c, const Key& k) { return c.key < k; });
  if (found == cells_.end() || found->key != key)
    found = cells_.insert(found, {key, std::make_unique<std::vector<Entry>>()});
  return *found->entries;
}

}  // namespace lcmslam
