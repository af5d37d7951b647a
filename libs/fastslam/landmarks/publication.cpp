#include <lcmslam/fastslam/landmarks/publication.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace lcmslam {

Landmark make_public(int slot, const ParticleMap& map, const LandmarkIndex& index) {
  const LandmarkRecord& record = index.record(slot);
  const LandmarkGaussian gaussian = *map.find(static_cast<std::size_t>(slot));
  return {record.id,       gaussian.mean, gaussian.covariance, record.observations,
          record.log_odds, record.colour, record.laplacian,    index.descriptor(slot)};
}

bool LandmarkPublication::differs(const Sent& sent, const CompactLandmark& now) const {
  const double before = sent.landmark.variance();
  return (sent.landmark.mean - now.mean).norm() > tolerance_ ||
         std::abs(now.variance() - before) > 0.5 * before;
}

MapChanges LandmarkPublication::take(const ParticleMap& map, LandmarkIndex& index,
                                     const std::function<Landmark(int)>& published) {
  MapChanges changes;
  sent_.resize(static_cast<std::size_t>(index.slots()));
  std::vector<int> moved;
  ParticleMap::for_each_difference(
      compared_, map, [&](std::size_t slot, const CompactLandmark* before, const CompactLandmark& now) {
        if (slot >= sent_.size() || (before && *before == now)) return;
        if (differs(sent_[slot], now)) moved.push_back(static_cast<int>(slot));
      });
  compared_ = map;
  const std::vector<int> touched = index.take_touched();
  std::vector<int> candidates;
  std::set_union(moved.begin(), moved.end(), touched.begin(), touched.end(), std::back_inserter(candidates));
  for (const int slot : candidates) {
    const LandmarkRecord& record = index.record(slot);
    Sent& sent = sent_[static_cast<std::size_t>(slot)];
    if (sent.id >= 0 && sent.id != record.id) {
      changes.removed.push_back(sent.id);
      sent.id = -1;
    }
    if (!index.alive(slot) || record.observations < minimum_observations_) continue;
    if (sent.id == record.id && !std::binary_search(moved.begin(), moved.end(), slot)) continue;
    changes.changed.push_back(published(slot));
    sent = {record.id, *map.find(static_cast<std::size_t>(slot))};
  }
  if (!changes.changed.empty() || !changes.removed.empty()) ++revision_;
  changes.revision = revision_;
  return changes;
}

}  // namespace lcmslam
