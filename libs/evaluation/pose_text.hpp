#pragma once
// Trajectories in the text formats of the field.
//
//   tum    t tx ty tz qx qy qz qw          a line, s and m; # begins a comment
//   euroc  t,px,py,pz,qw,qx,qy,qz[,...]    a line, ns and m; # begins a comment (EuRoC MAV's data.csv)
//   kitti  12 numbers of a 3x4 matrix      a line, row by row, m; no stamps
//
// KITTI's stamps are those of times.txt (a line each, s) in the same folder; without one its 10 Hz are
// assumed. Our own TUM files name their frames in the first line: `# frame: map, body: robot`.

#include <filesystem>
#include <string>

#include <lcmslam/evaluation/trajectory.hpp>

namespace lcmslam {

enum class PoseFormat { tum, euroc, kitti };

struct PoseText {
  Trajectory trajectory;  ///< sorted
  PoseFormat format = PoseFormat::tum;
  std::string body;        ///< frame whose poses they are, where the file says so, else empty
  std::string frame;       ///< frame in which they are given, likewise
  std::string assumption;  ///< what was assumed because the file does not say it, in words; empty: nothing
};

/// Knows the format by the first pose. Throws TrajectoryError naming the file, the line and what is expected.
PoseText read_pose_text(const std::filesystem::path& file);

/// Empty: not known.
struct PoseFrames {
  std::string frame, body;
};

/// write_tum() below a line that names the frames. The file is replaced whole or not at all;
/// std::runtime_error names it.
void save_tum(const std::filesystem::path& file, const Trajectory& trajectory, const PoseFrames& frames);
/// KITTI's matrices, and beside them STEM_times.txt, which read_pose_text() also takes. Throws likewise.
void save_kitti(const std::filesystem::path& file, const Trajectory& trajectory);

}  // namespace lcmslam
