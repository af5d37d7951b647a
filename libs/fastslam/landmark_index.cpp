#include "fastslam/landmark_index.hpp"

#include <algorithm>
#include <cmath>

namespace lcmslam {

int LandmarkIndex::add(const Feature& feature, const FastSlamSettings& settings) {
  int slot = slots();
  if (free_.empty()) {
    records_.emplace_back();
    descriptors_.emplace_back();
  } else {
    slot = free_.back();
    free_.pop_back();
  }
  LandmarkRecord& r = record(slot);
  r = LandmarkRecord();
  r.known_id = feature.landmark_id;
  r.id = r.known_id >= 0 ? r.known_id : next_id_++;
  if (r.known_id >= 0) known_slots_[r.known_id] = slot;
  r.colour = feature.colour;
  r.laplacian = feature.laplacian;
  r.observations = 1;
  r.log_odds = settings.odds_new;
  descriptors_[static_cast<std::size_t>(slot)] = feature.descriptor;
  return slot;
}

void LandmarkIndex::observe(int slot, const Feature& feature, const FastSlamSettings& settings) {
  LandmarkRecord& r = record(slot);
  ++r.observations;
  r.unseen_steps = 0;
  r.log_odds = std::min(r.log_odds + settings.odds_hit, settings.odds_maximum);
  const double blend = settings.descriptor_blend;
  if (blend <= 0) return;
  Descriptor& d = descriptors_[static_cast<std::size_t>(slot)];
  for (std::size_t i = 0; i < d.size(); ++i)
    d[i] = static_cast<std::uint8_t>(std::lround((1 - blend) * d[i] + blend * feature.descriptor[i]));
}

bool LandmarkIndex::miss(int slot, const FastSlamSettings& settings) {
  LandmarkRecord& r = record(slot);
  r.log_odds += settings.odds_miss;
  if (!settings.remove_landmarks || r.log_odds > settings.odds_remove) return false;
  release(slot);
  return true;
}

int LandmarkIndex::find(std::int32_t known_id) const {
  if (known_id < 0) return -1;
  const auto found = known_slots_.find(known_id);
  return found == known_slots_.end() ? -1 : found->second;
}

int LandmarkIndex::age(const FastSlamSettings& settings) {
  int forgotten = 0;
  for (int slot = 0; slot < slots(); ++slot) {
    LandmarkRecord& r = record(slot);
    if (r.id < 0 || ++r.unseen_steps <= settings.tentative_steps || r.known_id >= 0) continue;
    if (!settings.remove_landmarks || r.observations >= settings.minimum_observations) continue;
    release(slot);
    ++forgotten;
  }
  return forgotten;
}

void LandmarkIndex::release(int slot) {
  known_slots_.erase(record(slot).known_id);
  record(slot).id = -1;
  free_.push_back(slot);
}

}  // namespace lcmslam
