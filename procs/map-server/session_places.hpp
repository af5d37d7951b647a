#pragma once
// Where the current session lies in the map that the file had when this server began, and where in both
// something was seen. Works in a thread of its own.
//
// The map's frame is that of the file's first dense session that has features. Sessions of earlier runs whose
// place is not known are looked for in it first, then each new keyframe.

#include <atomic>
#include <filesystem>
#include <limits>
#include <map>
#include <mutex>

#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/places/session_joiner.hpp>
#include "procs/map-server/job_thread.hpp"

namespace lcmslam {

class SessionPlaces {
 public:
  /// Without `background` all is done by who hands it in. A file that is not there is an empty map. Of one
  /// that cannot be read nothing is known: error() says why, and no session is joined to another.
  SessionPlaces(const std::filesystem::path& file, bool background);

  /// Where the file could not be read for a reason that may have passed: its sessions up to this id.
  void read_again(std::int64_t newest);
  static constexpr std::int64_t all_sessions = std::numeric_limits<std::int64_t>::max();

  /// Another current session; what was found by the last one stays in the map. `stored`: its id in the file
  /// when it goes on from an earlier run, else 0.
  void begin_session(std::int64_t stored);
  /// The current session goes on from an earlier run after all: the file, which could not be read when it
  /// began, has it with this id. Its whole graph is to be followed.
  void go_on_as(std::int64_t stored);
  /// A session that was current is in the file now, with this id: its keyframes are among those that
  /// next_kept() gives.
  void keep(std::int64_t stored);

  // Of the current session.
  void keyframe(std::int32_t id, const Eigen::Isometry3d& T_session_camera, FeatureFrame features,
                ColouredCloud cloud);
  /// The graph has moved these, and given those up.
  void correct(const std::map<std::int32_t, Eigen::Isometry3d>& moved, const std::vector<std::int32_t>& gone);
  /// The whole graph has these: others have been given up, also while no server heard of it. One that lacks
  /// the most of the session's keyframes takes none away.
  void follow(const std::map<std::int32_t, Eigen::Isometry3d>& graph);
  /// What the file has of the session since an earlier run stays there as it is, and the session goes on in
  /// another one.
  void leave_stored();
  /// Another file, which is empty: what the former one had is gone. Keyframes that the current session has by
  /// now are found as before.
  void begin_file(const std::filesystem::path& file);

  /// A session whose place was found.
  struct Joined {
    std::int64_t stored = 0;  ///< its id in the file; 0: the current one
    Joint joint;
    bool again = false;  ///< it was found before, by fewer keyframes or before the graph moved them
    int number = 0;      ///< of calls of begin_session() before the one that was current
  };
  /// Since the last call; not what was found for a session that is not the current one any more.
  std::vector<Joined> take_joined();
  /// Whether a joint says something else than the one that was told last.
  static bool is_news(const Joint& joint, bool done, const std::optional<Joint>& told);
  /// Of those, without what is of another session than the one of this number.
  static std::vector<Joined> of_current(std::vector<Joined> joined, int number);
  /// Of the current session: from its frame to the map's, once that is known.
  std::optional<Eigen::Isometry3d> T_map_session() const;

  struct Answer {
    Located located;
    bool in_current = false;  ///< the place stands in the current session's frame, else in the map's
  };
  /// In the current session, or else in the map; in the current session's frame wherever that can be said.
  Answer locate(const FeatureFrame& features);

  /// The next keyframe of the file's map, in the current session's frame, with its images and its cloud: once
  /// the session was joined, one after the other. Not those of which later sessions have seen the same; where
  /// there are many of these in a row, none for now.
  struct KeptKeyframe {
    int number = 0;  ///< from 0
    Eigen::Isometry3d T_session_camera;
    std::optional<StoredImages> images;
    std::optional<ColouredCloud> cloud;
  };
  std::optional<KeptKeyframe> next_kept();
  /// Where those that next_kept() has given lie now, T_session_camera by number, once that is elsewhere: more
  /// keyframes may say where the session lies, or its graph has moved them.
  std::map<int, Eigen::Isometry3d> moved_kept();

  /// Keyframes of the file's map that things can be found by, and of the current session. While something is
  /// looked for, as they were before.
  std::size_t kept_keyframes() const;
  std::size_t current_keyframes() const;
  std::string error() const;

 private:
  struct Kept {
    std::int64_t session = 0;
    std::int32_t keyframe = 0;
    Eigen::Isometry3d T_map_camera;
  };
  void load(std::int64_t newest);
  void add_sessions(MapFile& map, std::optional<std::int64_t> frame,
                    const std::vector<StoredSession>& sessions, std::int64_t newest);
  // As MapFile's; error() says what is damaged.
  std::vector<StoredSession> sessions(MapFile& map);
  std::vector<StoredKeyframe> keyframes(MapFile& map, std::int64_t session);
  void note(const MapFile::Damage& damage);
  void tell_error(const std::string& error);
  void count_keyframes() const;
  /// What cannot be read says error(), and takes nothing else away.
  template <class Work>
  void attempt(const Work& work);
  /// What a keyframe is found by.
  struct Look {
    FeatureFrame features;
    ColouredCloud cloud;
  };
  std::optional<Look> look(MapFile& map, std::int64_t session, std::int32_t keyframe);
  void keep(const Kept& keyframe);
  bool is_outdated(std::size_t kept) const;
  static bool is_elsewhere(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);
  KeptKeyframe read_kept(std::size_t kept);
  void add_session(MapFile& map, std::int64_t session, const Eigen::Isometry3d& T_map_session);
  bool makes_frame() const;
  void leave_current();
  void begin_from(std::int64_t stored, std::unique_lock<std::mutex>& lock);
  void go_on(std::int64_t session);
  void look_for(std::int32_t id, const Eigen::Isometry3d& T_session_camera, const FeatureFrame& features,
                const ColouredCloud& cloud);
  void tell_joint();
  void apply(const std::map<std::int32_t, Eigen::Isometry3d>& moved, const std::vector<std::int32_t>& gone);
  std::vector<std::int32_t> missing(const std::map<std::int32_t, Eigen::Isometry3d>& graph) const;
  void correct_stored(const std::map<std::int32_t, Eigen::Isometry3d>& moved,
                      const std::vector<std::int32_t>& gone);
  void join_stored(MapFile& map, std::int64_t session);

  std::filesystem::path file_;
  int begun_ = 0;  // sessions, as who calls knows it

  bool is_read_ = false;  // what sessions the file has is known; the thread's own
  std::atomic<bool> may_be_read_later_ = false;
  mutable std::atomic<std::size_t> kept_keyframes_ = 0, current_keyframes_ = 0;

  mutable std::mutex error_mutex_;
  std::string error_;

  mutable std::mutex mutex_;  // guards what follows, held while something is looked for
  PlaceIndex map_, current_;
  SessionJoiner joiner_;
  std::int64_t first_session_ = 0;                           // whose frame is the map's, in the file
  int number_ = 0;                                           // of the current session
  std::int64_t stored_current_ = 0;                          // see begin_session()
  std::map<std::int64_t, Eigen::Isometry3d> T_map_session_;  // of sessions in the file, by id
  std::optional<Eigen::Isometry3d> T_map_current_;
  std::optional<Joint> told_;  // of the current session, last
  std::int64_t left_ = 0;      // current sessions that the map took over
  std::vector<Kept> kept_;
  std::size_t next_kept_ = 0;
  std::map<int, Eigen::Isometry3d> given_;  // of them, T_session_camera by number
  std::vector<Joined> joined_;

  JobThread jobs_;  // last: it ends before what it works on
};

}  // namespace lcmslam
