#pragma once
// The map's file while it is written: SQLite in WAL mode. What was committed survives the death of the
// process at any moment; when the power fails the file goes back to an earlier commit, whole.

#include <lcmslam/map_store/file/store_changes.hpp>
#include <lcmslam/map_store/file/store_schema.hpp>

namespace lcmslam {

class MapStore {
 public:
  /// Opens the file, or makes it; an older schema becomes today's. `vfs`: see Database. Throws StoreError.
  explicit MapStore(const std::filesystem::path& file, const char* vfs = nullptr);
  MapStore(const MapStore&) = delete;
  MapStore& operator=(const MapStore&) = delete;

  /// False: somebody has taken the file away, or another is in its place. As long as it is open here all of
  /// it is there.
  bool is_in_place() const { return !database_.has_moved(); }
  /// Somebody has written another file over it (`cp`): nothing of this one is there any more.
  bool was_overwritten() { return database_.was_overwritten(); }
  /// After each commit.
  void note_written() { database_.note_written(); }
  /// Before it is closed: whatever is in its place stays as it is.
  void leave_file() { database_.leave_file(); }
  /// All of it into a file that is there and empty. Throws StoreError.
  void copy_into(const std::filesystem::path& empty);

  // All of these inside a transaction; they throw StoreError, and then it is to be given up.

  Transaction begin() { return Transaction(database_); }
  /// Gives its id.
  std::int64_t add_run(const StoredRun& run);
  bool has_run(std::int64_t id);
  bool has_session(std::int64_t id);
  /// Gives its id; the one in `session` does not count.
  std::int64_t add_session(std::int64_t run, const StoredSession& session);
  void write(std::int64_t session, const SessionChanges& changes);
  /// Features, images and covariance of a keyframe that both sessions have, where the second has none of its
  /// own.
  void copy_keyframe(std::int64_t from_session, std::int64_t to_session, std::int32_t id);
  /// The newest of its sensor counts.
  void put_calibration(const StoredCalibration& calibration);
  /// Says where a session lies: state, T_map_session and evidence of the session with this id.
  void place_session(const StoredSession& session);

 private:
  void write_keyframe(std::int64_t session, std::int32_t id, const KeyframeChange& change);
  void write_images(std::int64_t session, std::int64_t keyframe, const StoredImages& images);
  std::optional<StoredCalibration> calibration_of(const StoredImages& images);
  void drop_keyframe(std::int64_t session, std::int32_t id);
  void write_edges(std::int64_t session, const SessionChanges& changes);
  void write_landmarks(std::int64_t session, const SessionChanges& changes);

  Database database_;
  struct Statements;
  struct Delete {
    void operator()(Statements* statements) const;
  };
  std::unique_ptr<Statements, Delete> statements_;
};

}  // namespace lcmslam
