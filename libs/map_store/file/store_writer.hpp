#pragma once
// Writes a map's changes into its file, in a thread of its own: whoever hands them in never waits for the
// disk. A commit follows within a tenth of a second. What cannot be written (full disk, folder that may not
// be written) waits, merged to its newest state, and is tried again every second. A file that somebody takes
// away meanwhile is written again, whole. One over which somebody writes another is left to that.

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <lcmslam/map_store/file/map_store.hpp>

namespace lcmslam {

class StoreWriter {
 public:
  struct State {
    std::int64_t commits = 0;
    std::int64_t failures = 0;
    std::int64_t restored = 0;  ///< times that the file had been taken away and was written again
    bool overwritten = false;   ///< another file was written over it: nothing goes into it any more
    std::string error;          ///< of the last try; empty: all that was tried is in the file
  };

  /// The file is opened, or made with its folder, when there is something to write. `run` is noted then.
  /// `vfs`: see Database.
  StoreWriter(std::filesystem::path file, StoredRun run, const char* vfs = nullptr);
  /// Tries once more to write what waits.
  ~StoreWriter();
  StoreWriter(const StoreWriter&) = delete;
  StoreWriter& operator=(const StoreWriter&) = delete;

  /// A number for change(): the session gets its id in the file with its first change. One that has an id
  /// already, of an earlier run, is gone on with.
  std::size_t begin_session(const StoredSession& session);
  /// One that began while nothing was written is in the file already, with this id.
  void go_on(std::size_t session, std::int64_t id);
  /// Calls `add` with what waits of this session.
  void change(std::size_t session, const std::function<void(SessionChanges&)>& add);
  /// The keyframes are those of another session as well: what that one has of their features, images and
  /// covariances by now belongs to this one, too, whatever becomes of it there.
  void share(std::size_t from, std::size_t to, const std::vector<std::int32_t>& keyframes);
  /// Says where the session lies: state, T_map_session and evidence of `place`.
  void place(std::size_t session, const StoredSession& place);
  void put_calibration(const StoredCalibration& calibration);

  /// Until `why` is empty nothing is written: that is what state() says.
  void hold(const std::string& why);

  /// Waits until what was handed in so far is in the file, or could not be written once more: false.
  bool flush();
  State state() const;
  /// Id in the file of a session of which nothing waits any more; nothing: something does.
  std::optional<std::int64_t> written(std::size_t session) const;

 private:
  struct Shared {
    std::size_t from, to;
    std::vector<std::int32_t> keyframes;
  };
  struct Waiting {
    std::map<std::size_t, SessionChanges> sessions;
    std::vector<Shared> shared;
    std::map<std::size_t, StoredSession> places;            // by change()'s number
    std::map<std::string, StoredCalibration> calibrations;  // by sensor
    bool empty() const {
      return sessions.empty() && shared.empty() && places.empty() && calibrations.empty();
    }
    bool touches(std::size_t session) const;
  };

  void work();
  void write(const Waiting& changes);
  void restore();
  void leave_overwritten();
  std::int64_t id_of(std::size_t session, std::int64_t run, std::map<std::size_t, std::int64_t>& ids);
  void put_back(Waiting&& failed);
  bool wait_for_work(std::unique_lock<std::mutex>& lock);

  const std::filesystem::path file_;
  const StoredRun run_;
  const char* const vfs_;

  mutable std::mutex mutex_;
  std::condition_variable wake_, done_;
  Waiting waiting_;
  std::vector<StoredSession> sessions_;  // by change()'s number
  State state_;
  std::string held_;                          // see hold()
  std::int64_t tries_asked_ = 0, tries_ = 0;  // flush() waits for a try that began after it
  bool stop_ = false, writing_ = false;

  std::map<std::size_t, std::int64_t> ids_;  // of sessions that are in the file; only the thread changes it

  // The thread's own.
  std::unique_ptr<MapStore> store_;
  std::int64_t run_id_ = 0;  // 0: not in the file yet
  std::thread thread_;
};

}  // namespace lcmslam
