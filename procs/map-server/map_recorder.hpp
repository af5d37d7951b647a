#pragma once
// Hands what the map server holds to the map's file (map_store/file), as it arrives. Nothing here waits for
// the disk.

#include <chrono>
#include <deque>
#include <filesystem>
#include <map>
#include <set>
#include <string>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/file/store_writer.hpp>
#include <lcmslam/map_store/landmark_map.hpp>
#include <lcmslam/messages/stored_calibration.hpp>
#include <lcmslam/places/session_joiner.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include "procs/map-server/session_table.hpp"

namespace lcmslam {

/// A session that is in the file and not in memory: of an earlier run, or one that was retired.
struct KeptSession {
  std::int64_t id = 0;         ///< in the file
  std::string mapper;          ///< "fastslam" or "icp"
  std::string name;            ///< "icp-session1": as the files that it is exported to
  std::int64_t keyframes = 0;  ///< that have a cloud
  std::int64_t landmarks = 0;
  Utime begin = 0, end = 0;  ///< us, of the first and the last keyframe; 0: not known
};

class MapRecorder {
 public:
  /// A file that is there is gone on with; one that cannot be read stays as it is, and error() says why. As
  /// long as that may pass (somebody holds it) nothing is written: read_again().
  MapRecorder(const std::filesystem::path& file, const std::string& configuration);
  /// Where the old file could not be read yet. Sessions that have begun by then and that it has, as their
  /// mappers lived on, go on: graph() and landmarks() are to be told whole. True when it was read.
  bool read_again(std::chrono::milliseconds patience);
  /// It was read, or is not there.
  bool is_read() const { return unreadable_.empty(); }
  /// Of the sessions of earlier runs the newest, by id; 0: there are none.
  std::int64_t newest_of_before() const { return newest_of_before_; }

  /// After the message changed the map. `whole`: all of the map may be another. What takes the most of the
  /// file's landmarks away leaves those beside, as a graph does.
  void landmarks(const SessionKey& key, const landmarks_t& message, const LandmarkMap& map, bool whole);
  void keyframe(const SessionKey& key, const DenseKeyframe& keyframe);
  /// What it was shown to derived maps with.
  void images(const SessionKey& key, std::int32_t keyframe, StoredImages images);
  /// As an earlier run of this server kept them, for a session that goes on; what cannot be read is not
  /// there.
  std::optional<StoredImages> kept_images(const SessionKey& key, std::int32_t keyframe);
  /// After graph and map have followed the message. A graph that takes the most of what the file has away
  /// leaves that beside: the map goes on in a session of its own.
  void graph(const SessionKey& key, const graph_t& message, const FollowedGraph& graph, const DenseMap& map);
  /// Maps that nobody adds to any more: sessions of their own, whatever is in the file. `of`: the session
  /// whose keyframes those were, which has their features and images.
  void kept_beside(const SessionKey& key, const DenseMap& map, const SessionKey& of);
  void kept_beside(const SessionKey& key, const LandmarkMap& map);
  /// A mapper's pose of the robot.
  void pose(const std::string& mapper, const SessionKey& key, const pose_estimate_t& message);
  void features(const SessionKey& key, std::int32_t keyframe, const FeatureFrame& features);
  /// Where a session lies: the mapper's, or one of an earlier run.
  void place(const std::string& mapper, const SessionKey& key, const Joint& joint);
  void place(std::int64_t stored, const Joint& joint);
  void calibration(const camera_calibration_t& message);

  /// A session that nobody adds to any more becomes one of those that are kept, as after a restart of this
  /// server; its id in the file. Nothing while some of it waits to be written.
  std::optional<std::int64_t> retire(const std::string& mapper, const SessionKey& key);

  /// Writes what waits; false: it could not be written.
  bool flush() { return writer_.flush(); }
  StoreWriter::State state() const { return writer_.state(); }
  /// Why nothing is written; empty: all is well.
  std::string error() const;
  /// What of the old file is damaged; empty: nothing.
  std::string damage() const;

  const std::filesystem::path& file() const { return file_; }
  /// In the order in which they began; not those without a map, nor those whose mapper has been heard again:
  /// while that lives its session goes on.
  const std::vector<KeptSession>& kept() const { return kept_; }
  /// Id in the file of the session that goes on from an earlier run; 0: it is none.
  std::int64_t stored(const std::string& mapper, const SessionKey& key);
  /// The same, without beginning it.
  std::int64_t goes_on(const std::string& mapper, const SessionKey& key) const;
  /// What says where that session of an earlier run lies in the map, "" for the one whose frame that is;
  /// nothing: it lies apart.
  std::optional<std::string> evidence(std::int64_t stored) const;
  /// Sessions of earlier runs and retired ones, whether they have a map or not: so many numbers are taken.
  std::size_t kept(const std::string& mapper) const;

 private:
  struct Session {
    std::size_t number = 0;                   // the writer's
    std::int64_t kept_id = 0;                 // in the file, of one that goes on from an earlier run; 0: none
    std::map<std::int32_t, Utime> keyframes;  // that the file has
    std::size_t unheard_landmarks = 0;      // that the file has of an earlier run, until all are heard again
    std::optional<KeptSession> was_kept{};  // as it was told until its mapper was heard again
    bool is_beside = false;                 // another map than one that the file has under this name
  };

  void read_kept(std::chrono::milliseconds patience);
  void keep(MapFile& map, const StoredSession& session, MapFile::Damage* damage);
  std::string number(const StoredSession& session);
  Session& session(const std::string& mapper, const SessionKey& key);
  Session& begin_session(const std::string& mapper, const SessionKey& key, Session& session);
  std::int64_t take_up(const std::string& mapper, const SessionKey& key, Session& session);
  void go_on_with_stored();
  Session& new_session(const std::string& mapper, const SessionKey& key);
  void leave_beside(const std::string& mapper, const SessionKey& key, Session& session);
  void put_keyframe(Session& session, const DenseKeyframe& keyframe);
  void put_keyframes(Session& session, const DenseMap& map, std::size_t shared_with);
  std::optional<Matrix6d> covariance_at(Utime utime) const;

  std::filesystem::path file_;
  std::string unreadable_;             // why an old file could not be read
  bool may_be_read_later_ = false;     // that may pass
  MapFile::Damage damage_;             // of what it has
  std::int64_t newest_of_before_ = 0;  // session, by id
  std::chrono::steady_clock::time_point next_retiring_{};
  std::vector<StoredSession> stored_;                                       // that are not in memory
  std::map<std::int64_t, std::map<std::int32_t, Utime>> stored_keyframes_;  // by session
  std::vector<KeptSession> kept_;
  std::map<std::string, std::int64_t> frame_sessions_;  // whose frame is the map's, by mapper
  std::map<std::pair<std::string, std::pair<std::int64_t, std::string>>, Session> sessions_;
  std::deque<std::pair<Utime, Matrix6d>> covariances_;  // of the last ICP_POSEs
  std::map<std::string, std::vector<std::uint8_t>> calibrations_;
  StoreWriter writer_;
};

}  // namespace lcmslam
