#pragma once
// Reads a map file: what is there at the moment at which it is opened, while somebody else may go on writing.

#include <lcmslam/features/landmark.hpp>
#include <lcmslam/map_store/dense_map.hpp>
#include <lcmslam/map_store/file/store_schema.hpp>
#include <lcmslam/map_store/file/stored_map.hpp>

namespace lcmslam {

/// How much a session has of everything.
struct SessionCounts {
  std::int64_t keyframes = 0, clouds = 0, points = 0, features = 0, images = 0, edges = 0, landmarks = 0;
};

/// "icp-session1", "icp-session2": each one's own, counted by mapper, as exported files are called.
std::vector<std::string> names_of(const std::vector<StoredSession>& sessions);

/// False: there is no such file. Where nobody can say (a folder that may not be entered, a disk that fails)
/// it may be there, and reading it says what is wrong.
bool may_be_there(const std::filesystem::path& file);

class MapFile {
 public:
  /// Files of older schemas are read, too. Throws StoreError.
  explicit MapFile(const std::filesystem::path& file,
                   std::chrono::milliseconds patience = Database::usual_patience);

  // All of these throw StoreError that names the file and the row where something cannot be read. Who gives
  // `damage` is told it there, and gets the rest.

  using Damage = std::vector<std::string>;
  int schema() const { return schema_; }
  std::vector<StoredRun> runs();
  /// In the order in which they began. One whose place is damaged has none.
  std::vector<StoredSession> sessions(Damage* damage = nullptr);
  SessionCounts counts(std::int64_t session);
  /// Of this mapper's sessions the one whose frame is the map's, by id: the first in which others can be
  /// found, so it has features or landmarks; where none has, the first. Nothing: there is no session.
  std::optional<std::int64_t> frame_session(const std::string& mapper);
  /// Of each sensor as it was told last.
  std::vector<StoredCalibration> calibrations();
  /// By which images were taken; images() gives each with its own.
  std::vector<StoredCalibration> cameras();

  /// By id; those of a graph that has no clouds, too.
  std::vector<StoredKeyframe> keyframes(std::int64_t session, Damage* damage = nullptr);
  std::vector<StoredEdge> edges(std::int64_t session);
  /// Of keyframes with a cloud; nothing when it has none.
  std::optional<ColouredCloud> cloud(std::int64_t session, std::int32_t keyframe);
  std::optional<FeatureFrame> features(std::int64_t session, std::int32_t keyframe);
  std::optional<StoredImages> images(std::int64_t session, std::int32_t keyframe);
  /// All keyframes that have clouds.
  DenseMap dense_map(std::int64_t session);
  /// By id.
  std::vector<Landmark> landmarks(std::int64_t session);
  /// In the order in which it was written.
  std::vector<StoredPose> trajectory(std::int64_t session);

  Database& database() { return database_; }

 private:
  std::vector<StoredCalibration> read_calibrations(Statement& rows);
  std::shared_ptr<const StoredCalibration> camera(std::int64_t id);
  std::shared_ptr<const StoredCalibration> first_camera(const std::string& sensor);
  StoredKeyframe keyframe_in(const Statement& row, std::int64_t session);
  template <class Decode>
  auto decoded(const char* what, std::int64_t session, std::int64_t id, const Decode& decode);

  Database database_;
  int schema_ = 0;
  Transaction moment_;
};

}  // namespace lcmslam
