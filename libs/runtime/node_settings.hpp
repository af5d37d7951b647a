#pragma once
// Settings that several nodes have.

#include <string>

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

inline void describe_frame_queue(SettingsVisitor& s, int& frames) {
  s.number("frame_queue", frames, "", {1, 10000},
           "frames that may wait before the oldest is skipped: few keep answers fresh, many leave no gap in "
           "a replay");
}

inline void describe_max_wait(SettingsVisitor& s, double& seconds) {
  s.number(
      "max_wait", seconds, "s", {0, 10},
      "of message time that a frame waits for its odometry; then it goes on without, and that is counted");
}

/// `map`: the frame of a process's first map.
inline void describe_map_frame(SettingsVisitor& s, std::string& map) {
  s.text("map_frame", map,
         "name of the first map's frame; later ones (time began anew, reset) get a number behind it. Launch "
         "names a process that it restarts another one: nobody knows yet where its map lies in the old one");
}

/// Name of the frame of a process's n-th map, from 1.
inline std::string map_frame_of(const std::string& first, std::int64_t session) {
  return session <= 1 ? first : first + "-" + std::to_string(session);
}

/// The frame beside a map's in which the pose never jumps: map-2's is local-2.
inline std::string local_frame_of(const std::string& map_frame) {
  return map_frame.rfind("map", 0) == 0 ? "local" + map_frame.substr(3) : map_frame + "-local";
}

/// What a pose in a frame other than "map" must say; empty for "map".
inline std::string unplaced_map(const std::string& frame) {
  return frame == "map" ? "" : "where " + frame + " lies in map is not known";
}
inline void add_detail(std::string& detail, const std::string& more) {
  if (!more.empty()) detail += (detail.empty() ? "" : "; ") + more;
}

/// How the robot moves: "auto", "planar" or "6dof".
inline void describe_pose(SettingsVisitor& s, std::string& pose) {
  s.choice("pose", pose, {"auto", "planar", "6dof"},
           "planar on the ground, or all six degrees of freedom; auto: planar where the camera has a mount");
}

}  // namespace lcmslam
