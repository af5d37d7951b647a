#include "fastslam/publication.hpp"

#include <cmath>

namespace lcmslam {

Landmark make_public(int slot, const ParticleMap& map, const LandmarkIndex& index) {
  const LandmarkRecord& record = index.record(slot);
  const LandmarkGaussian& gaussian = *map.find(static_cast<std::size_t>(slot));
  return {record.id,       gaussian.mean, gaussian.covariance, record.observations,
          record.log_odds, record.colour, record.laplacian,    index.descriptor(slot)};
}

bool LandmarkPublication::differs(const Sent& sent, const LandmarkGaussian& now) const {
  const double before = sent.gaussian.covariance.trace();
  return (sent.gaussian.mean - now.mean).norm() > tolerance_ ||
         std::abs(now.covariance.trace() - before) > 0.5 * before;
}

MapChanges LandmarkPublication::take(const ParticleMap& map, const LandmarkIndex& index) {
  MapChanges changes;
  sent_.resize(static_cast<std::size_t>(index.slots()));
  std::vector<char> moved(sent_.size(), 0);
  ParticleMap::for_each_difference(
      compared_, map, [&](std::size_t slot, const LandmarkGaussian*, const LandmarkGaussian& now) {
        if (slot < sent_.size()) moved[slot] = differs(sent_[slot], now);
      });
  compared_ = map;
  for (std::size_t i = 0; i < sent_.size(); ++i) {
    const int slot = static_cast<int>(i);
    const LandmarkRecord& record = index.record(slot);
    Sent& sent = sent_[i];
    if (sent.id >= 0 && sent.id != record.id) {
      changes.removed.push_back(sent.id);
      sent.id = -1;
    }
    if (!index.alive(slot) || record.observations < minimum_observations_) continue;
    if (sent.id == record.id && !moved[i]) continue;
    changes.changed.push_back(make_public(slot, map, index));
    sent = {record.id, *map.find(i)};
  }
  if (!changes.changed.empty() || !changes.removed.empty()) ++revision_;
  changes.revision = revision_;
  return changes;
}

}  // namespace lcmslam
