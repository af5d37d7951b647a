#include "procs/map-server/landmark_sessions.hpp"

#include <utility>

namespace lcmslam {
namespace {

constexpr std::size_t most_groups = 200;

}  // namespace

LandmarkSessions::LandmarkSessions(const std::filesystem::path& file, bool background)
    : file_(file), jobs_(background, most_groups) {
  jobs_.hand_in([this] { load(); });
}

void LandmarkSessions::load() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!std::filesystem::exists(file_)) return;
  try {
    MapFile map(file_);
    std::vector<std::int64_t> unknown;
    for (const StoredSession& session : map.sessions()) {
      if (session.mapper != "fastslam" || map.counts(session.id).landmarks == 0) continue;
      if (map_.size() == 0 || session.T_map_session)
        place(session.id, map.landmarks(session.id),
              session.T_map_session.value_or(Eigen::Isometry3d::Identity()));
      else
        unknown.push_back(session.id);
    }
    for (const std::int64_t session : unknown) {
      const std::vector<Landmark> landmarks = map.landmarks(session);
      LandmarkJoiner joiner;
      joiner.add_all(landmarks, map_);
      if (!joiner.joint()) continue;
      joined_.push_back({session, *joiner.joint()});
      place(session, landmarks, joiner.joint()->T_map_session);
    }
  } catch (const std::exception&) {
    // What was read before the damage serves.
  }
}

void LandmarkSessions::place(std::int64_t session, const std::vector<Landmark>& landmarks,
                             const Eigen::Isometry3d& T_map_session) {
  map_.add(landmarks, T_map_session);
  kept_ = map_.size();
  T_map_session_[session] = T_map_session;
  if (session == stored_current_) T_map_current_ = T_map_session;
}

void LandmarkSessions::begin_session(std::int64_t stored, std::vector<Landmark> last) {
  newest_ = -1;
  jobs_.hand_in([this, stored, last = std::move(last), number = ++begun_] {
    const std::lock_guard<std::mutex> lock(mutex_);
    number_ = number;
    // A mapper that begins anew looks for its last map, too, where it is known how that lies.
    if (map_.size() == 0) T_map_current_ = Eigen::Isometry3d::Identity();
    if (T_map_current_ && T_map_session_.count(stored_current_) == 0) map_.add(last, *T_map_current_);
    kept_ = map_.size();
    joiner_ = LandmarkJoiner();
    stored_current_ = stored;
    const auto known = T_map_session_.find(stored);
    T_map_current_.reset();
    if (known != T_map_session_.end()) T_map_current_ = known->second;
  });
}

/// A group is looked for once the next one is there: its landmarks have been seen for a while then.
void LandmarkSessions::follow(const LandmarkMap& map) {
  constexpr std::size_t size = LandmarkJoiner::group_size;
  std::vector<Landmark> group = map.after(newest_, 2 * size);
  if (group.size() < 2 * size) return;
  group.resize(size);
  newest_ = group.back().id;
  jobs_.hand_in([this, group = std::move(group)] {
    const std::lock_guard<std::mutex> lock(mutex_);
    look_for(group);
  });
}

void LandmarkSessions::look_for(const std::vector<Landmark>& group) {
  const bool known = T_map_session_.count(stored_current_) > 0;
  if (known || map_.size() == 0 || joiner_.done()) return;
  joiner_.add(group, map_);
  if (!joiner_.joint()) return;
  const bool again = T_map_current_.has_value();
  T_map_current_ = joiner_.joint()->T_map_session;
  if (!again || joiner_.done()) joined_.push_back({0, *joiner_.joint(), again, number_});
}

std::vector<LandmarkSessions::Joined> LandmarkSessions::take_joined() {
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);  // else the next time
  return lock ? SessionPlaces::of_current(std::exchange(joined_, {}), begun_) : std::vector<Joined>();
}

}  // namespace lcmslam
