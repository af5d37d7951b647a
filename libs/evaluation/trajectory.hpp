#pragma once
// Trajectories: stamped poses, in memory and in the TUM benchmark's text format.

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

struct StampedPose {
  Utime utime = 0;
  Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
  /// Of T_world_body exp(xi): translation (m), rotation (rad), body frame; where it is known.
  std::optional<Matrix6d> covariance = std::nullopt;
};

/// Sorted by time, one pose a stamp (`sort_trajectory` establishes it).
using Trajectory = std::vector<StampedPose>;

/// A trajectory file that cannot be used: names the file, the line and what would be right.
class TrajectoryError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Sorts by stamp; of several poses with one stamp the last is kept (as TUM's tools do: published
/// stamps are rounded).
void sort_trajectory(Trajectory& trajectory);

/// TUM format: `t tx ty tz qx qy qz qw` a line (s, m, unit quaternion), separated by blanks, tabs or
/// commas; empty lines and lines that begin with # are skipped. Lines may stand in any order.
/// Throws TrajectoryError.
Trajectory read_tum(const std::filesystem::path& file);
/// `name` stands in the errors.
Trajectory read_tum(std::istream& text, const std::string& name);

/// Stamps with microseconds, positions with 9 and quaternions with 12 decimals. The file is replaced whole or
/// not at all; std::runtime_error names it.
void write_tum(const std::filesystem::path& file, const Trajectory& trajectory);
void write_tum(std::ostream& text, const Trajectory& trajectory);

/// The same motion, of another frame that is fixed to the body: T_world_body * T_body_other.
Trajectory in_other_frame(const Trajectory& trajectory, const Eigen::Isometry3d& T_body_other);

/// Pose at a time between two poses at most `max_gap` seconds apart; nothing outside.
std::optional<Eigen::Isometry3d> pose_at(const Trajectory& trajectory, Utime utime, double max_gap = 0.5);

/// Length of the path in m.
double path_length(const Trajectory& trajectory);

}  // namespace lcmslam
