#pragma once
// How far a mapper's poses lie from the truth while it drives: for who watches. Truth has a frame of its own;
// both are taken for one where they first met, so that what is told is the error since then. (Evaluation of
// a whole run aligns whole paths: evaluation/.)

#include <deque>
#include <map>
#include <optional>
#include <string>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

class TruthError {
 public:
  /// The robot's true pose, in order of time.
  void truth(Utime utime, const Eigen::Isometry3d& T_world_robot);
  /// m; nothing where no truth is known for that time. `who` is a name, `frame` of its map: another one is
  /// met anew.
  std::optional<double> error(const std::string& who, const std::string& frame, Utime utime,
                              const Eigen::Isometry3d& T_map_robot);
  /// The true pose as seen in that map, once they have met.
  std::optional<Eigen::Isometry3d> in_map(const std::string& who,
                                          const Eigen::Isometry3d& T_world_robot) const;

 private:
  struct Meeting {
    std::string frame;
    Eigen::Isometry3d T_map_world;
  };
  std::optional<Eigen::Isometry3d> at(Utime utime) const;

  std::deque<std::pair<Utime, Eigen::Isometry3d>> truth_;  // the last seconds'
  std::map<std::string, Meeting> meetings_;
};

}  // namespace lcmslam
