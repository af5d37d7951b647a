#pragma once
// Where the robot is at each time, in space: a path seen from above, driven on the ground.

#include <vector>

#include <lcmslam/simulation/ground.hpp>
#include <lcmslam/simulation/planar_path.hpp>
#include <lcmslam/simulation/repeated_lap.hpp>

namespace lcmslam {

class DrivenPath {
 public:
  /// On the flat floor.
  DrivenPath(PlanarPath path) : path_(std::move(path)) {}
  /// `lap` is of that path.
  DrivenPath(PlanarPath path, Ground ground, std::vector<CarryingWheel> wheels, RepeatedLap lap = {})
      : path_(std::move(path)), ground_(std::move(ground)), wheels_(std::move(wheels)), lap_(lap) {}

  double length() const { return path_.length() + lap_.more_length(); }  ///< m, seen from above
  double duration() const { return lap_.driven(path_.duration()); }      ///< s, rests included
  /// T_world_robot, clamped to 0..duration.
  Eigen::Isometry3d pose(double seconds) const {
    return stand_on(ground_, wheels_, path_.pose(lap_.planned(seconds)));
  }
  const RepeatedLap& lap() const { return lap_; }

 private:
  PlanarPath path_;
  Ground ground_;
  std::vector<CarryingWheel> wheels_;
  RepeatedLap lap_;
};

}  // namespace lcmslam
