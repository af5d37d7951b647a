// What the file's map has, to be shown beside the current session.

#include <algorithm>
#include <set>

#include "procs/map-server/session_places.hpp"

namespace lcmslam {
namespace {

constexpr int enough_later = 2;  // sessions that saw the same

}  // namespace

void SessionPlaces::keep(std::int64_t stored) {
  jobs_.hand_in([this, stored] {
    try {
      MapFile map(file_);
      for (const StoredSession& session : sessions(map)) {
        if (session.id != stored) continue;
        const std::vector<StoredKeyframe> keyframes = this->keyframes(map, stored);
        const std::lock_guard<std::mutex> lock(mutex_);
        if (map.frame_session("icp") == stored && map.counts(stored).features > 0) first_session_ = stored;
        if (stored != first_session_ && !session.T_map_session) return;
        const Eigen::Isometry3d T = session.T_map_session.value_or(Eigen::Isometry3d::Identity());
        T_map_session_[stored] = T;  // should its mapper come back
        for (const StoredKeyframe& keyframe : keyframes)
          keep({stored, keyframe.id, T * keyframe.T_map_camera});
      }
    } catch (const std::exception& error) {
      tell_error(error.what());
    }
  });
}

/// Its graph may have moved it since it was read. Numbers of keyframes (next_kept()) stay.
void SessionPlaces::keep(const Kept& keyframe) {
  const auto known = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) {
    return kept.session == keyframe.session && kept.keyframe == keyframe.keyframe;
  });
  if (known != kept_.end())
    *known = keyframe;
  else
    kept_.push_back(keyframe);
}

/// A room that is mapped again and again must not take longer to be shown each time.
bool SessionPlaces::is_outdated(std::size_t kept) const {
  const PlaceSettings same;  // what PlaceIndex takes for one view
  std::set<std::int64_t> later;
  for (std::size_t i = kept + 1; i < kept_.size(); ++i)
    if (kept_[i].session != kept_[kept].session &&
        distance_between(kept_[i].T_map_camera, kept_[kept].T_map_camera) < same.same_view_distance &&
        angle_between(kept_[i].T_map_camera, kept_[kept].T_map_camera) < same.same_view_angle)
      later.insert(kept_[i].session);
  return later.size() >= enough_later;
}

/// Of a session that goes on from an earlier run its mapper sends its own keyframes again.
std::optional<SessionPlaces::KeptKeyframe> SessionPlaces::next_kept() {
  constexpr int most_looks = 20;  // so that nobody waits for it
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
  if (!lock || !T_map_current_) return std::nullopt;
  for (int look = 0; look < most_looks && next_kept_ < kept_.size(); ++look) {
    const std::size_t i = next_kept_++;
    if (kept_[i].session == stored_current_ || is_outdated(i)) continue;
    KeptKeyframe keyframe = read_kept(i);
    given_[keyframe.number] = keyframe.T_session_camera;
    return keyframe;
  }
  return std::nullopt;
}

std::map<int, Eigen::Isometry3d> SessionPlaces::moved_kept() {
  std::map<int, Eigen::Isometry3d> moved;
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);  // else the next time
  if (!lock || !T_map_current_) return moved;
  const Eigen::Isometry3d T_session_map = T_map_current_->inverse();
  for (auto& [number, T_given] : given_) {
    const Eigen::Isometry3d T = T_session_map * kept_[static_cast<std::size_t>(number)].T_map_camera;
    if (is_elsewhere(T, T_given)) moved[number] = T_given = T;
  }
  return moved;
}

SessionPlaces::KeptKeyframe SessionPlaces::read_kept(std::size_t i) {
  const Kept& kept = kept_[i];
  KeptKeyframe keyframe{static_cast<int>(i), T_map_current_->inverse() * kept.T_map_camera, {}, {}};
  try {
    MapFile map(file_);
    keyframe.cloud = map.cloud(kept.session, kept.keyframe);  // images may be another calibration's
    keyframe.images = map.images(kept.session, kept.keyframe);
  } catch (const std::exception& error) {
    tell_error(error.what());
  }
  return keyframe;
}

}  // namespace lcmslam
