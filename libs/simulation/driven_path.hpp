#pragma once
// Where the robot is at each time, in space: a path seen from above, driven on the ground.

#include <vector>

#include <lcmslam/simulation/ground.hpp>
#include <lcmslam/simulation/planar_path.hpp>

namespace lcmslam {

class DrivenPath {
 public:
  /// On the flat floor.
  DrivenPath(PlanarPath path) : path_(std::move(path)) {}
  DrivenPath(PlanarPath path, Ground ground, std::vector<CarryingWheel> wheels)
      : path_(std::move(path)), ground_(std::move(ground)), wheels_(std::move(wheels)) {}

  double length() const { return path_.length(); }      ///< m, seen from above
  double duration() const { return path_.duration(); }  ///< s, rests included
  /// T_world_robot, clamped to 0..duration.
  Eigen::Isometry3d pose(double seconds) const { return stand_on(ground_, wheels_, path_.pose(seconds)); }

 private:
  PlanarPath path_;
  Ground ground_;
  std::vector<CarryingWheel> wheels_;
};

}  // namespace lcmslam
