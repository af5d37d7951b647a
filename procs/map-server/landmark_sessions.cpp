#include "procs/map-server/landmark_sessions.hpp"

#include <utility>

namespace lcmslam {
namespace {

constexpr std::size_t most_groups = 200;

}  // namespace

LandmarkSessions::LandmarkSessions(const std::filesystem::path& file, bool background)
    : file_(file), jobs_(background, most_groups) {
  jobs_.hand_in([this] { load(SessionPlaces::all_sessions); });
}

void LandmarkSessions::read_again(std::int64_t newest) {
  if (may_be_read_later_.exchange(false)) jobs_.hand_in([this, newest] { load(newest); });
}

void LandmarkSessions::load(std::int64_t newest) {
  const std::lock_guard<std::mutex> lock(mutex_);
  note_error("");
  is_read_ = !may_be_there(file_);
  if (is_read_) return;
  attempt([&] {
    try {
      MapFile map(file_);
      MapFile::Damage of_places;  // SessionPlaces says it
      const std::vector<StoredSession> sessions = map.sessions(&of_places);
      is_read_ = true;
      add_sessions(map, sessions, newest);
    } catch (const PassingStoreError&) {
      may_be_read_later_ = !is_read_;
      throw;
    }
  });
}

void LandmarkSessions::add_sessions(MapFile& map, const std::vector<StoredSession>& sessions,
                                    std::int64_t newest) {
  std::vector<std::int64_t> unknown;
  for (const StoredSession& session : sessions) {
    if (session.id > newest || session.mapper != "fastslam" || map.counts(session.id).landmarks == 0)
      continue;
    if (first_session_ == 0) first_session_ = session.id;
    if (session.id == first_session_ || session.T_map_session)
      attempt([&] {
        place(session.id, map.landmarks(session.id),
              session.T_map_session.value_or(Eigen::Isometry3d::Identity()));
      });
    else
      unknown.push_back(session.id);
  }
  for (const std::int64_t session : unknown) attempt([&] { join_stored(map, session); });
}

template <class Work>
void LandmarkSessions::attempt(const Work& work) {
  try {
    work();
  } catch (const std::exception& error) {
    note_error(error.what());
  }
}

void LandmarkSessions::join_stored(MapFile& map, std::int64_t session) {
  const std::vector<Landmark> landmarks = map.landmarks(session);
  LandmarkJoiner joiner;
  joiner.add_all(landmarks, map_);
  if (!joiner.joint()) return;
  joined_.push_back({session, *joiner.joint()});
  place(session, landmarks, joiner.joint()->T_map_session);
}

void LandmarkSessions::place(std::int64_t session, const std::vector<Landmark>& landmarks,
                             const Eigen::Isometry3d& T_map_session) {
  map_.add(landmarks, T_map_session, session);
  kept_ = map_.size();
  T_map_session_[session] = T_map_session;
  if (session == stored_current_) T_map_current_ = T_map_session;
}

void LandmarkSessions::begin_session(std::int64_t stored, LandmarkMap last) {
  newest_ = -1;
  jobs_.hand_in([this, stored, last = std::move(last), number = ++begun_] {
    const std::lock_guard<std::mutex> lock(mutex_);
    number_ = number;
    leave_current(last);
    joiner_ = LandmarkJoiner();
    begin_from(stored);
  });
}

void LandmarkSessions::go_on_as(std::int64_t stored) {
  jobs_.hand_in([this, stored] {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (stored != stored_current_) begin_from(stored);
  });
}

void LandmarkSessions::begin_file(const std::filesystem::path& file) {
  jobs_.hand_in([this, file] {
    const std::lock_guard<std::mutex> lock(mutex_);
    file_ = file;
    is_read_ = true;
    map_ = LandmarkPlaces();
    kept_ = 0;
    joiner_ = LandmarkJoiner();
    first_session_ = stored_current_ = 0;
    T_map_session_.clear();
    T_map_current_.reset();
    told_.reset();
    joined_.clear();
  });
}

void LandmarkSessions::begin_from(std::int64_t stored) {
  stored_current_ = stored;
  const auto known = T_map_session_.find(stored);
  T_map_current_.reset();
  told_.reset();
  if (known == T_map_session_.end()) return;
  T_map_current_ = known->second;
  if (stored != first_session_) go_on(stored);
}

/// As SessionPlaces.
bool LandmarkSessions::makes_frame() const {
  const bool is_first = first_session_ == 0 || first_session_ == stored_current_;
  return is_read_ && is_first && map_.size() == 0;
}

/// A mapper that begins anew looks for its last map, too, where it is known how that lies. What the file had
/// of that goes: the mapper has learned more. Where a part alone has come it stays.
void LandmarkSessions::leave_current(const LandmarkMap& last) {
  if (makes_frame()) T_map_current_ = Eigen::Isometry3d::Identity();
  if (!T_map_current_ || last.size() == 0) return;
  if (stored_current_ != 0 && !last.incomplete()) map_.drop(stored_current_);
  map_.add(last.landmarks(), *T_map_current_, stored_current_);
  kept_ = map_.size();
}

/// As SessionPlaces: what was joined in an earlier run goes on and its mapper learns more, so that it is
/// taken out of the map, and asked for its place again.
void LandmarkSessions::go_on(std::int64_t session) {
  map_.drop(session);
  kept_ = map_.size();
  T_map_session_.erase(session);
  attempt([&] {  // else its next groups say where it lies
    joiner_.add_all(MapFile(file_).landmarks(session), map_);
    tell_joint();
  });
}

/// A group is looked for once the next one is there: its landmarks have been seen for a while then.
void LandmarkSessions::follow(const LandmarkMap& map) {
  follow_moved(map);
  constexpr std::size_t size = LandmarkJoiner::group_size;
  std::vector<Landmark> group = map.after(newest_, 2 * size);
  if (group.size() < 2 * size) return;
  group.resize(size);
  newest_ = group.back().id;
  jobs_.hand_in_missable([this, group = std::move(group)] {
    const std::lock_guard<std::mutex> lock(mutex_);
    look_for(group);
  });
}

/// Where it lies follows its map, as a dense session's follows its graph.
void LandmarkSessions::follow_moved(const LandmarkMap& map) {
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
  const bool is_of_this_session = lock && number_ == begun_;  // else the next time
  if (is_of_this_session && joiner_.move([&](std::int64_t id) { return map.find(id); })) tell_joint();
}

void LandmarkSessions::look_for(const std::vector<Landmark>& group) {
  const bool known = T_map_session_.count(stored_current_) > 0;
  if (known || map_.size() == 0 || joiner_.done()) return;
  joiner_.add(group, map_);
  tell_joint();
}

void LandmarkSessions::tell_joint() {
  if (!joiner_.joint()) return;
  const Joint& joint = *joiner_.joint();
  T_map_current_ = joint.T_map_session;
  if (!SessionPlaces::is_news(joint, joiner_.done(), told_)) return;
  joined_.push_back({0, joint, told_.has_value(), number_});
  told_ = joint;
}

std::vector<LandmarkSessions::Joined> LandmarkSessions::take_joined() {
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);  // else the next time
  return lock ? SessionPlaces::of_current(std::exchange(joined_, {}), begun_) : std::vector<Joined>();
}

void LandmarkSessions::note_error(const std::string& error) {
  const std::lock_guard<std::mutex> lock(error_mutex_);
  error_ = error;
}

std::string LandmarkSessions::error() const {
  const std::lock_guard<std::mutex> lock(error_mutex_);
  return error_;
}

}  // namespace lcmslam
