#include "procs/map-server/session_places.hpp"

#include <algorithm>
#include <iterator>
#include <set>

namespace lcmslam {
namespace {

constexpr std::size_t most_places = 200;
std::int64_t index_key(std::int64_t session, std::int32_t keyframe) {
  return (session << 32) + keyframe;
}

}  // namespace

SessionPlaces::SessionPlaces(const std::filesystem::path& file, bool background)
    : file_(file), jobs_(background, most_places) {
  jobs_.hand_in([this] { load(all_sessions); });
}

void SessionPlaces::read_again(std::int64_t newest) {
  if (may_be_read_later_.exchange(false)) jobs_.hand_in([this, newest] { load(newest); });
}

template <class Work>
void SessionPlaces::attempt(const Work& work) {
  try {
    work();
  } catch (const std::exception& error) {
    tell_error(error.what());
  }
}

void SessionPlaces::load(std::int64_t newest) {
  tell_error("");
  is_read_ = !may_be_there(file_);
  if (is_read_) return;
  attempt([&] {
    try {
      MapFile map(file_);
      const std::optional<std::int64_t> frame = map.frame_session("icp");
      const std::vector<StoredSession> sessions = this->sessions(map);
      is_read_ = true;
      add_sessions(map, frame, sessions, newest);
    } catch (const PassingStoreError&) {
      may_be_read_later_ = !is_read_;
      throw;
    }
  });
}

void SessionPlaces::add_sessions(MapFile& map, std::optional<std::int64_t> frame,
                                 const std::vector<StoredSession>& sessions, std::int64_t newest) {
  std::vector<std::int64_t> unknown;
  for (const StoredSession& session : sessions) {
    if (session.id > newest || session.mapper != "icp" || map.counts(session.id).features == 0) continue;
    if (session.id == frame) first_session_ = session.id;
    if (session.id == frame || session.T_map_session)
      attempt([&] {
        add_session(map, session.id, session.T_map_session.value_or(Eigen::Isometry3d::Identity()));
      });
    else
      unknown.push_back(session.id);
  }
  for (const std::int64_t session : unknown) attempt([&] { join_stored(map, session); });
}

std::vector<StoredSession> SessionPlaces::sessions(MapFile& map) {
  MapFile::Damage damage;
  std::vector<StoredSession> sessions = map.sessions(&damage);
  note(damage);
  return sessions;
}

std::vector<StoredKeyframe> SessionPlaces::keyframes(MapFile& map, std::int64_t session) {
  MapFile::Damage damage;
  std::vector<StoredKeyframe> keyframes = map.keyframes(session, &damage);
  note(damage);
  return keyframes;
}

void SessionPlaces::tell_error(const std::string& error) {
  const std::lock_guard<std::mutex> lock(error_mutex_);
  error_ = error;
}

void SessionPlaces::note(const MapFile::Damage& damage) {
  if (!damage.empty()) tell_error(damage.front());
}

std::optional<SessionPlaces::Look> SessionPlaces::look(MapFile& map, std::int64_t session,
                                                       std::int32_t keyframe) {
  std::optional<Look> look;
  attempt([&] {
    auto features = map.features(session, keyframe);
    auto cloud = map.cloud(session, keyframe);
    if (features && cloud) look = Look{std::move(*features), std::move(*cloud)};
  });
  return look;
}

void SessionPlaces::add_session(MapFile& map, std::int64_t session, const Eigen::Isometry3d& T_map_session) {
  for (const StoredKeyframe& keyframe : keyframes(map, session)) {
    const auto seen = look(map, session, keyframe.id);
    const Eigen::Isometry3d T_map_camera = T_map_session * keyframe.T_map_camera;
    const std::lock_guard<std::mutex> lock(mutex_);
    kept_.push_back({session, keyframe.id, T_map_camera});
    if (seen) map_.add(index_key(session, keyframe.id), T_map_camera, seen->features, seen->cloud);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  T_map_session_[session] = T_map_session;
  if (session == stored_current_) T_map_current_ = T_map_session;
}

void SessionPlaces::join_stored(MapFile& map, std::int64_t session) {
  SessionJoiner joiner;
  for (const StoredKeyframe& keyframe : keyframes(map, session)) {
    if (joiner.done()) break;
    const auto seen = look(map, session, keyframe.id);
    const std::lock_guard<std::mutex> lock(mutex_);
    if (seen) joiner.add(keyframe.T_map_camera, seen->features, seen->cloud, map_);
  }
  if (!joiner.joint()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    joined_.push_back({session, *joiner.joint()});
  }
  add_session(map, session, joiner.joint()->T_map_session);
}

void SessionPlaces::begin_session(std::int64_t stored) {
  jobs_.hand_in([this, stored, number = ++begun_] {
    std::unique_lock<std::mutex> lock(mutex_);
    number_ = number;
    leave_current();
    current_ = PlaceIndex();
    joiner_ = SessionJoiner();
    next_kept_ = 0;
    given_.clear();
    begin_from(stored, lock);
  });
}

void SessionPlaces::go_on_as(std::int64_t stored) {
  jobs_.hand_in([this, stored] {
    std::unique_lock<std::mutex> lock(mutex_);
    if (stored != stored_current_) begin_from(stored, lock);
  });
}

/// `lock` is open then.
void SessionPlaces::begin_from(std::int64_t stored, std::unique_lock<std::mutex>& lock) {
  stored_current_ = stored;
  const auto known = T_map_session_.find(stored);
  T_map_current_.reset();
  told_.reset();
  if (known == T_map_session_.end()) return;
  T_map_current_ = known->second;
  lock.unlock();
  if (stored != first_session_) go_on(stored);  // the first makes the frame
}

/// What was joined in an earlier run goes on, and its graph moves it: it is taken out of the map, and asked
/// for its place again.
void SessionPlaces::go_on(std::int64_t session) {
  attempt([&] {
    MapFile map(file_);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      for (const Kept& kept : kept_)
        if (kept.session == session) map_.drop(index_key(session, kept.keyframe));
      T_map_session_.erase(session);
    }
    for (const StoredKeyframe& keyframe : keyframes(map, session)) {
      const auto seen = look(map, session, keyframe.id);
      const std::lock_guard<std::mutex> lock(mutex_);
      if (seen) look_for(keyframe.id, keyframe.T_map_camera, seen->features, seen->cloud);
    }
  });
}

/// Whether the current session's frame is the map's. Not where the file has a first one of which nothing can
/// be found, nor where it could not be read: what is joined to it is written down, and would be wrong.
bool SessionPlaces::makes_frame() const {
  const bool is_first = first_session_ == 0 || first_session_ == stored_current_;
  return is_read_ && is_first && map_.size() == 0;
}

/// A mapper that begins anew looks for its last map, too, where it is known how that lies.
void SessionPlaces::leave_current() {
  if (makes_frame()) T_map_current_ = Eigen::Isometry3d::Identity();
  if (!T_map_current_) return;
  const std::int64_t left = stored_current_ != 0 ? stored_current_ : -(++left_);
  map_.take_over(current_, *T_map_current_, index_key(left, 0));
}

void SessionPlaces::keyframe(std::int32_t id, const Eigen::Isometry3d& T_session_camera,
                             FeatureFrame features, ColouredCloud cloud) {
  jobs_.hand_in_missable(
      [this, id, T_session_camera, features = std::move(features), cloud = std::move(cloud)] {
        const std::lock_guard<std::mutex> lock(mutex_);
        look_for(id, T_session_camera, features, cloud);
      });
}

/// A keyframe of the current session.
void SessionPlaces::look_for(std::int32_t id, const Eigen::Isometry3d& T_session_camera,
                             const FeatureFrame& features, const ColouredCloud& cloud) {
  current_.add(id, T_session_camera, features, cloud);
  const bool known = T_map_session_.count(stored_current_) > 0;
  if (known || map_.size() == 0 || joiner_.done()) return;
  joiner_.add(T_session_camera, features, cloud, map_, id);
  tell_joint();
}

/// The more keyframes say where the session lies, and the better its graph knows them, the better it is
/// known.
void SessionPlaces::tell_joint() {
  if (!joiner_.joint()) return;
  const Joint& joint = *joiner_.joint();
  T_map_current_ = joint.T_map_session;
  if (!is_news(joint, joiner_.done(), told_)) return;
  joined_.push_back({0, joint, told_.has_value(), number_});
  told_ = joint;
}

bool SessionPlaces::is_elsewhere(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  constexpr double moved_distance = 0.001, moved_angle = 0.0005;  // m, rad
  return distance_between(a, b) > moved_distance || angle_between(a, b) > moved_angle;
}

bool SessionPlaces::is_news(const Joint& joint, bool done, const std::optional<Joint>& told) {
  return !told || (done && joint.agreeing > told->agreeing) ||
         is_elsewhere(joint.T_map_session, told->T_map_session);
}

void SessionPlaces::correct(const std::map<std::int32_t, Eigen::Isometry3d>& moved,
                            const std::vector<std::int32_t>& gone) {
  jobs_.hand_in([this, moved, gone] {
    const std::lock_guard<std::mutex> lock(mutex_);
    apply(moved, gone);
  });
}

void SessionPlaces::follow(const std::map<std::int32_t, Eigen::Isometry3d>& graph) {
  jobs_.hand_in([this, graph] {
    const std::lock_guard<std::mutex> lock(mutex_);
    apply(graph, missing(graph));
  });
}

void SessionPlaces::leave_stored() {
  jobs_.hand_in([this] {
    const std::lock_guard<std::mutex> lock(mutex_);
    stored_current_ = 0;
  });
}

void SessionPlaces::begin_file(const std::filesystem::path& file) {
  jobs_.hand_in([this, file] {
    const std::lock_guard<std::mutex> lock(mutex_);
    file_ = file;
    is_read_ = true;
    map_ = PlaceIndex();
    joiner_ = SessionJoiner();
    first_session_ = stored_current_ = 0;
    T_map_session_.clear();
    T_map_current_.reset();
    told_.reset();
    kept_.clear();
    next_kept_ = 0;
    given_.clear();
    joined_.clear();
  });
}

void SessionPlaces::apply(const std::map<std::int32_t, Eigen::Isometry3d>& moved,
                          const std::vector<std::int32_t>& gone) {
  for (const auto& [id, T_session_camera] : moved) current_.move(id, T_session_camera);
  for (const std::int32_t id : gone) current_.drop(id);
  correct_stored(moved, gone);
  joiner_.drop(gone);
  joiner_.move(moved);
  tell_joint();
}

/// Keyframes of the current session that the graph has not; none where these are the most.
std::vector<std::int32_t> SessionPlaces::missing(
    const std::map<std::int32_t, Eigen::Isometry3d>& graph) const {
  std::set<std::int32_t> known;
  for (const std::int64_t key : current_.keys(0, index_key(1, 0)))
    known.insert(static_cast<std::int32_t>(key));
  if (T_map_session_.count(stored_current_) > 0)
    for (const std::int64_t key : map_.keys(index_key(stored_current_, 0), index_key(stored_current_ + 1, 0)))
      known.insert(static_cast<std::int32_t>(key - index_key(stored_current_, 0)));
  std::vector<std::int32_t> gone;
  std::copy_if(known.begin(), known.end(), std::back_inserter(gone),
               [&](std::int32_t id) { return graph.count(id) == 0; });
  if (2 * gone.size() > known.size()) gone.clear();
  return gone;
}

/// Of a session that goes on, what the map has of it since an earlier run.
void SessionPlaces::correct_stored(const std::map<std::int32_t, Eigen::Isometry3d>& moved,
                                   const std::vector<std::int32_t>& gone) {
  const auto known = T_map_session_.find(stored_current_);
  if (known == T_map_session_.end()) return;
  for (const auto& [id, T_session_camera] : moved)
    map_.move(index_key(stored_current_, id), known->second * T_session_camera);
  for (const std::int32_t id : gone) map_.drop(index_key(stored_current_, id));
}

std::vector<SessionPlaces::Joined> SessionPlaces::of_current(std::vector<Joined> joined, int number) {
  const auto is_of_another = [&](const Joined& j) { return j.stored == 0 && j.number != number; };
  joined.erase(std::remove_if(joined.begin(), joined.end(), is_of_another), joined.end());
  return joined;
}

std::vector<SessionPlaces::Joined> SessionPlaces::take_joined() {
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);  // else the next time
  return lock ? of_current(std::exchange(joined_, {}), begun_) : std::vector<Joined>();
}

std::optional<Eigen::Isometry3d> SessionPlaces::T_map_session() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return T_map_current_;
}

SessionPlaces::Answer SessionPlaces::locate(const FeatureFrame& features) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Answer answer{current_.locate(features), true};
  if (answer.located.place) {
    if (T_map_current_) map_.look_for_twin(features, *T_map_current_, answer.located);
    return answer;
  }
  Located in_map = map_.locate(features);
  if (!in_map.place) return answer;
  answer = {std::move(in_map), T_map_current_.has_value()};
  if (!T_map_current_) return answer;
  current_.look_for_twin(features, T_map_current_->inverse(), answer.located);
  if (std::optional<Place>& place = answer.located.place)
    place->T_map_camera = T_map_current_->inverse() * place->T_map_camera;
  return answer;
}

/// STATUS asks after almost each message, and must not wait for what is looked for.
void SessionPlaces::count_keyframes() const {
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
  if (!lock) return;
  kept_keyframes_ = map_.size();
  current_keyframes_ = current_.size();
}

std::size_t SessionPlaces::kept_keyframes() const {
  count_keyframes();
  return kept_keyframes_;
}

std::size_t SessionPlaces::current_keyframes() const {
  count_keyframes();
  return current_keyframes_;
}

std::string SessionPlaces::error() const {
  const std::lock_guard<std::mutex> lock(error_mutex_);
  return error_;
}

}  // namespace lcmslam
