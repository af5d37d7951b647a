#include <lcmslam/fastslam/landmarks/landmark_index.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace lcmslam {

int LandmarkIndex::add(const Feature& feature, const FastSlamSettings& settings) {
  int slot = slots();
  if (free_.empty()) {
    records_.emplace_back();
    is_touched_.push_back(0);
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
  r.seen_step = step_;
  if (r.known_id < 0 && settings.remove_landmarks)
    tentative_.insert({step_ + settings.tentative_steps + 1, slot, r.id});
  touch(slot);
  if (r.known_id >= 0)
    known_descriptors_[slot] = feature.descriptor;
  else
    search_.insert(slot, feature.descriptor, feature.laplacian);
  return slot;
}

void LandmarkIndex::observe(int slot, const Feature& feature, const FastSlamSettings& settings) {
  LandmarkRecord& r = record(slot);
  ++r.observations;
  r.seen_step = step_;
  touch(slot);
  r.log_odds = std::min(r.log_odds + settings.odds_hit, settings.odds_maximum);
  const double blend = settings.descriptor_blend;
  if (blend <= 0 || r.known_id >= 0 || feature.landmark_id >= 0) return;
  Descriptor d = search_.descriptor(slot);
  const auto newest = static_cast<unsigned>(std::lround(256 * blend)), former = 256 - newest;
  for (std::size_t i = 0; i < d.size(); ++i)
    d[i] = static_cast<std::uint8_t>((former * d[i] + newest * feature.descriptor[i] + 128) / 256);
  search_.update(slot, d);
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
  ++step_;
  int forgotten = 0;
  while (!tentative_.empty() && tentative_.begin()->step <= step_) {
    const Due due = *tentative_.begin();
    tentative_.erase(tentative_.begin());
    if (record(due.slot).id != due.id || record(due.slot).observations >= settings.minimum_observations)
      continue;  // died, or is well established
    if (unseen_steps(due.slot) > settings.tentative_steps) {
      release(due.slot);
      ++forgotten;
    } else {
      tentative_.insert({record(due.slot).seen_step + settings.tentative_steps + 1, due.slot, due.id});
    }
  }
  return forgotten;
}

std::vector<int> LandmarkIndex::take_touched() {
  std::sort(touched_.begin(), touched_.end());
  for (const int slot : touched_) is_touched_[static_cast<std::size_t>(slot)] = 0;
  return std::exchange(touched_, {});
}

void LandmarkIndex::touch(int slot) {
  char& touched = is_touched_[static_cast<std::size_t>(slot)];
  if (!touched) touched_.push_back(slot);
  touched = 1;
}

void LandmarkIndex::release(int slot) {
  if (record(slot).known_id >= 0) {
    known_slots_.erase(record(slot).known_id);
    known_descriptors_.erase(slot);
  } else {
    search_.remove(slot);
  }
  record(slot).id = -1;
  free_.push_back(slot);
  touch(slot);
}

}  // namespace lcmslam
