#include <lcmslam/map_store/file/store_writer.hpp>

#include <algorithm>
#include <chrono>
#include <set>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/map_store/file/clear_beside.hpp>

namespace lcmslam {
namespace {

// So that, with the time that a commit takes, at most a second is lost when the process is killed.
constexpr std::chrono::milliseconds commit_period(100);
constexpr std::chrono::milliseconds retry_period(1000);

}  // namespace

StoreWriter::StoreWriter(std::filesystem::path file, StoredRun run, const char* vfs)
    : file_(std::move(file)), run_(std::move(run)), vfs_(vfs), thread_([this] { work(); }) {}

StoreWriter::~StoreWriter() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  thread_.join();
  if (store_ && store_->was_overwritten()) store_->leave_file();
}

std::size_t StoreWriter::begin_session(const StoredSession& session) {
  const std::lock_guard<std::mutex> lock(mutex_);
  sessions_.push_back(session);
  return sessions_.size() - 1;
}

void StoreWriter::go_on(std::size_t session, std::int64_t id) {
  const std::lock_guard<std::mutex> lock(mutex_);
  sessions_[session].id = id;
}

void StoreWriter::change(std::size_t session, const std::function<void(SessionChanges&)>& add) {
  bool is_first = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_first = waiting_.empty();
    add(waiting_.sessions[session]);
  }
  if (is_first) wake_.notify_all();  // else it is awake, or lets more gather
}

// What waits is handed over here, what is in the file when it is written.
void StoreWriter::share(std::size_t from, std::size_t to, const std::vector<std::int32_t>& keyframes) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto waiting = waiting_.sessions.find(from);
    if (waiting != waiting_.sessions.end()) waiting_.sessions[to].share(waiting->second, keyframes);
    waiting_.shared.push_back({from, to, keyframes});
  }
  wake_.notify_all();
}

void StoreWriter::place(std::size_t session, const StoredSession& place) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_.places[session] = place;
  }
  wake_.notify_all();
}

void StoreWriter::put_calibration(const StoredCalibration& calibration) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_.calibrations[calibration.sensor] = calibration;
  }
  wake_.notify_all();
}

void StoreWriter::hold(const std::string& why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  held_ = why;
}

bool StoreWriter::flush() {
  std::unique_lock<std::mutex> lock(mutex_);
  if (waiting_.empty() && tries_ >= tries_asked_ && state_.error.empty() && !writing_) return true;
  const std::int64_t wanted = ++tries_asked_;
  wake_.notify_all();
  done_.wait(lock, [&] { return tries_ >= wanted; });
  return state_.error.empty();
}

StoreWriter::State StoreWriter::state() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return state_;
}

std::optional<std::int64_t> StoreWriter::written(std::size_t session) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto id = ids_.find(session);
  if (waiting_.touches(session) || writing_ || id == ids_.end()) return std::nullopt;
  return id->second;
}

bool StoreWriter::Waiting::touches(std::size_t session) const {
  return sessions.count(session) > 0 || places.count(session) > 0 ||
         std::any_of(shared.begin(), shared.end(),
                     [&](const Shared& s) { return s.from == session || s.to == session; });
}

/// False: it is time to end, and nothing waits.
bool StoreWriter::wait_for_work(std::unique_lock<std::mutex>& lock) {
  const auto is_urgent = [&] { return stop_ || tries_asked_ > tries_; };
  wake_.wait(lock, [&] { return is_urgent() || !waiting_.empty(); });
  if (!is_urgent()) wake_.wait_for(lock, state_.error.empty() ? commit_period : retry_period, is_urgent);
  return !stop_ || !waiting_.empty();
}

void StoreWriter::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (wait_for_work(lock)) {
    const std::int64_t asked = tries_asked_;
    const bool last_try = stop_;
    Waiting changes = std::exchange(waiting_, {});
    std::string error = changes.empty() ? "" : held_;
    writing_ = true;
    lock.unlock();
    try {
      if (!changes.empty() && error.empty()) write(changes);
    } catch (const std::exception& failure) {
      error = failure.what();
      // Opened anew, as the folder or the file may be others by then; but one that was taken away is nowhere
      // else.
      if (store_ && store_->is_in_place()) store_.reset();
    }
    lock.lock();
    writing_ = false;
    if (!changes.empty()) ++(error.empty() ? state_.commits : state_.failures);
    state_.error = error;
    tries_ = asked;
    if (!error.empty()) put_back(std::move(changes));
    done_.notify_all();
    if (last_try) break;
  }
}

/// All of it in one transaction. What was begun in the file counts only when that is committed.
void StoreWriter::write(const Waiting& changes) {
  if (store_ && store_->was_overwritten()) leave_overwritten();
  if (state().overwritten)
    throw StoreError(file_.string() + ": another file was written over it while it was open here");
  if (store_ && !store_->is_in_place()) restore();
  if (!store_) {
    std::filesystem::create_directories(std::filesystem::absolute(file_).parent_path());
    store_ = std::make_unique<MapStore>(file_, vfs_);
    if (!store_->has_run(run_id_)) {  // somebody took the file away: a new one begins
      run_id_ = 0;
      const std::lock_guard<std::mutex> lock(mutex_);
      ids_.clear();
    }
  }
  std::int64_t run = run_id_;
  std::map<std::size_t, std::int64_t> ids = ids_;
  Transaction transaction = store_->begin();
  if (run == 0) run = store_->add_run(run_);
  for (const auto& [sensor, calibration] : changes.calibrations) store_->put_calibration(calibration);
  std::set<std::size_t> written;
  const auto write_session = [&](std::size_t number) {
    const auto session = changes.sessions.find(number);
    if (session == changes.sessions.end() || !written.insert(number).second) return;
    store_->write(id_of(number, run, ids), session->second);
  };
  for (const Shared& s : changes.shared) {  // before they go in the session that they come from
    write_session(s.to);
    for (const std::int32_t keyframe : s.keyframes)
      store_->copy_keyframe(id_of(s.from, run, ids), id_of(s.to, run, ids), keyframe);
  }
  for (const auto& [number, session] : changes.sessions) write_session(number);
  for (auto [number, place] : changes.places) {
    place.id = id_of(number, run, ids);
    store_->place_session(place);
  }
  transaction.commit();
  store_->note_written();
  run_id_ = run;
  const std::lock_guard<std::mutex> lock(mutex_);
  ids_ = std::move(ids);
}

/// SQLite's log is of the map that was there, and would go into the one that is there now, page by page.
void StoreWriter::leave_overwritten() {
  store_->leave_file();
  store_.reset();
  const std::lock_guard<std::mutex> lock(mutex_);
  state_.overwritten = true;
}

/// SQLite would write on into a file without a name, and nobody would know.
void StoreWriter::restore() {
  std::error_code ignored;
  if (std::filesystem::exists(std::filesystem::symlink_status(file_, ignored)))
    throw StoreError(
        file_.string() +
        ": another file is in its place; once that is moved away the map is written there again");
  std::filesystem::create_directories(std::filesystem::absolute(file_).parent_path());
  write_atomically(file_, [&](const std::filesystem::path& part) {
    store_->copy_into(part);
    clear_beside(file_);  // the log of the one that was taken away would be written over it
  });
  store_.reset();
  const std::lock_guard<std::mutex> lock(mutex_);
  ++state_.restored;
}

/// In the file, where it begins when it has not yet.
std::int64_t StoreWriter::id_of(std::size_t session, std::int64_t run,
                                std::map<std::size_t, std::int64_t>& ids) {
  std::int64_t& id = ids[session];
  if (id != 0) return id;
  std::unique_lock<std::mutex> lock(mutex_);
  const StoredSession begun = sessions_[session];
  lock.unlock();
  return id = store_->has_session(begun.id) ? begun.id : store_->add_session(run, begun);
}

void StoreWriter::put_back(Waiting&& failed) {
  Waiting newer = std::exchange(waiting_, std::move(failed));
  // What did not wait when it was shared, nor came into the file.
  for (const Shared& s : newer.shared) {
    const auto source = waiting_.sessions.find(s.from);
    if (source != waiting_.sessions.end()) waiting_.sessions[s.to].share(source->second, s.keyframes);
  }
  for (auto& [number, session] : newer.sessions) waiting_.sessions[number].follow(std::move(session));
  waiting_.shared.insert(waiting_.shared.end(), newer.shared.begin(), newer.shared.end());
  for (auto& [number, place] : newer.places) waiting_.places[number] = std::move(place);
  for (auto& [sensor, calibration] : newer.calibrations)
    waiting_.calibrations[sensor] = std::move(calibration);
}

}  // namespace lcmslam
