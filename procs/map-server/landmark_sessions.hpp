#pragma once
// Where FastSLAM's current session lies in the landmarks that the file had when this server began: as
// SessionPlaces for the dense map, in a thread of its own.
//
// The frame is that of the file's first session with landmarks. Sessions of earlier runs whose place is not
// known are looked for in it first, then each group of new landmarks.

#include <atomic>

#include <lcmslam/map_store/landmark_map.hpp>
#include <lcmslam/places/landmark_joiner.hpp>
#include "procs/map-server/session_places.hpp"

namespace lcmslam {

class LandmarkSessions {
 public:
  /// As SessionPlaces.
  LandmarkSessions(const std::filesystem::path& file, bool background);

  /// As SessionPlaces.
  void read_again(std::int64_t newest);
  /// Another current session; `last`: that of the one before, which stays in the map. `stored`: its id in the
  /// file when it goes on from an earlier run, else 0.
  void begin_session(std::int64_t stored, LandmarkMap last);
  /// As SessionPlaces.
  void go_on_as(std::int64_t stored);
  /// As SessionPlaces.
  void begin_file(const std::filesystem::path& file);
  /// The current session's map has changed.
  void follow(const LandmarkMap& map);

  using Joined = SessionPlaces::Joined;
  /// As SessionPlaces.
  std::vector<Joined> take_joined();
  /// Of the file's map.
  std::size_t kept_landmarks() const { return kept_; }
  std::string error() const;

 private:
  void load(std::int64_t newest);
  void add_sessions(MapFile& map, const std::vector<StoredSession>& sessions, std::int64_t newest);
  void note_error(const std::string& error);
  template <class Work>
  void attempt(const Work& work);
  void join_stored(MapFile& map, std::int64_t session);
  void place(std::int64_t session, const std::vector<Landmark>& landmarks,
             const Eigen::Isometry3d& T_map_session);
  bool makes_frame() const;
  void leave_current(const LandmarkMap& last);
  void begin_from(std::int64_t stored);
  void go_on(std::int64_t session);
  void follow_moved(const LandmarkMap& map);
  void look_for(const std::vector<Landmark>& group);
  void tell_joint();

  std::filesystem::path file_;
  int begun_ = 0;             // sessions, as who calls knows it
  std::int64_t newest_ = -1;  // landmark of the current session that was looked for

  std::atomic<std::size_t> kept_ = 0;

  std::atomic<bool> may_be_read_later_ = false;
  mutable std::mutex error_mutex_;
  std::string error_;

  std::mutex mutex_;  // guards what follows, held while something is looked for
  LandmarkPlaces map_;
  LandmarkJoiner joiner_;
  std::int64_t first_session_ = 0;  // whose frame is the map's, in the file
  int number_ = 0;                  // of the current session
  std::int64_t stored_current_ = 0;
  std::map<std::int64_t, Eigen::Isometry3d> T_map_session_;  // of sessions in the file, by id
  std::optional<Eigen::Isometry3d> T_map_current_;
  std::optional<Joint> told_;  // of the current session, last
  std::vector<Joined> joined_;
  bool is_read_ = false;  // what sessions the file has is known

  JobThread jobs_;  // last: it ends before what it works on
};

}  // namespace lcmslam
