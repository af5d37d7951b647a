#include <lcmslam/map_store/landmark_map.hpp>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace lcmslam {
namespace {

constexpr std::size_t recent_changes = 256;
constexpr int max_tiles = 100'000;

}  // namespace

void LandmarkMap::put(const LandmarkChange& change) {
  if (change.base_revision == 0) landmarks_.clear();
  for (const std::int64_t id : change.removed) landmarks_.erase(id);
  for (const Landmark& landmark : change.upserted) landmarks_[landmark.id] = landmark;
  revision_ = change.revision;
}

bool LandmarkMap::contained(const LandmarkChange& change) const {
  return !incomplete_ && change.revision == revision_;
}

void LandmarkMap::check_room(std::size_t landmarks) const {
  if (landmarks > most_landmarks_)
    throw std::invalid_argument("the map has as many landmarks as it may, " +
                                std::to_string(most_landmarks_));
}

bool LandmarkMap::apply(const LandmarkChange& change) {
  if (contained(change)) return true;
  const bool anew = change.base_revision == 0;
  const auto is_new = [&](const Landmark& l) { return anew || landmarks_.count(l.id) == 0; };
  check_room((anew ? 0 : landmarks_.size()) +
             static_cast<std::size_t>(std::count_if(change.upserted.begin(), change.upserted.end(), is_new)));
  const bool follows = change.base_revision == revision_;
  const bool late = !anew && !follows && change.revision <= revision_;
  if (anew) {
    clear();
  } else if (!follows) {
    incomplete_ = true;
  }
  if (late)  // perhaps a mapper that began anew: its revisions and the old ones do not mix
    while (!recent_.empty() && recent_.back().revision > change.revision) recent_.pop_back();
  recent_.push_back(change);
  if (recent_.size() > recent_changes) recent_.pop_front();
  if (!late) put(change);  // what is old must not overwrite what is newer
  return !incomplete_;
}

bool LandmarkMap::add_tile(const LandmarkTile& tile) {
  if (tile.tiles < 1 || tile.tiles > max_tiles || tile.tile < 0 || tile.tile >= tile.tiles)
    throw std::invalid_argument("landmark tile " + std::to_string(tile.tile) + " of " +
                                std::to_string(tile.tiles) + ": must be from 0 to tiles - 1, at most " +
                                std::to_string(max_tiles) + " tiles");
  if (!incomplete_ && tile.revision <= revision_ && revision_ != 0) return false;
  const auto tiles = static_cast<std::size_t>(tile.tiles);
  if (tile.revision != pending_revision_ || tiles != pending_tiles_) {
    pending_.clear();
    pending_revision_ = tile.revision;
    pending_tiles_ = tiles;
  }
  std::size_t coming = tile.landmarks.size();
  for (const auto& [index, part] : pending_) coming += index != tile.tile ? part.size() : 0;
  check_room(coming);
  pending_[tile.tile] = tile.landmarks;
  if (pending_.size() < pending_tiles_) return false;

  landmarks_.clear();
  for (const auto& [index, part] : pending_)
    for (const Landmark& landmark : part) landmarks_[landmark.id] = landmark;
  revision_ = pending_revision_;
  incomplete_ = false;
  pending_.clear();
  pending_tiles_ = 0;
  const std::deque<LandmarkChange> meanwhile = std::move(recent_);
  recent_.clear();
  for (const LandmarkChange& change : meanwhile)
    if (change.base_revision != 0 && change.revision > revision_) apply(change);
  return true;
}

void LandmarkMap::clear() {
  *this = LandmarkMap(most_landmarks_);
}

const Landmark* LandmarkMap::find(std::int64_t id) const {
  const auto found = landmarks_.find(id);
  return found == landmarks_.end() ? nullptr : &found->second;
}

std::vector<Landmark> LandmarkMap::after(std::int64_t id, std::size_t most) const {
  std::vector<Landmark> next;
  for (auto landmark = landmarks_.upper_bound(id); landmark != landmarks_.end() && next.size() < most;
       ++landmark)
    next.push_back(landmark->second);
  return next;
}

std::vector<Landmark> LandmarkMap::landmarks() const {
  std::vector<Landmark> ordered;
  ordered.reserve(landmarks_.size());
  for (const auto& [id, landmark] : landmarks_) ordered.push_back(landmark);
  return ordered;
}

}  // namespace lcmslam
