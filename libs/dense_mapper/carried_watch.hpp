#pragma once
// Whether somebody has carried the robot. Where the map ends a frame fits nowhere, either, and there odometry
// is right; a carried robot sees something else than the map has where odometry says it is:
// - its wheels have not led out of what it saw when it was placed last, or
// - it looks through surfaces of the map.
// Who sees only things that stand before all that the map has there has not been carried for that: somebody
// stands close, and as long as the wheels stand they tell where the robot is. Nor has a robot that drives
// with something new before it that goes as fast (Tracked::held). A frame is one or the other; only a second
// of frames that agree says that the robot was carried.

#include <lcmslam/dense_mapper/tracker.hpp>

namespace lcmslam {

class VoxelMap;

class CarriedWatch {
 public:
  explicit CarriedWatch(const DenseMapperSettings& settings) : settings_(settings) {}

  /// `tracked`: where odometry led the robot, and registration from there; `placed`: the map says where it
  /// is; `adrift`: odometry has lost the way, so that it contradicts nothing.
  void observe(const PreparedFrame& prepared, const Tracked& tracked, bool placed, bool adrift,
               const VoxelMap& map);

  /// Frames have contradicted the map since the robot was placed last.
  bool contradicted() const { return settings_.carried_after > 0 && contradicted_ > 0; }
  bool carried() const { return carried_; }
  /// What stands close hides the map from the last frame, about where the robot was placed last: it says
  /// neither that the robot is there nor that it is not.
  bool blocked() const { return blocked_; }
  /// s of frames since it was carried that fit nowhere; 0 while the robot is where it is thought to be.
  double unplaced() const { return unplaced_; }

 private:
  bool is_contradicted(const PreparedFrame& prepared, const Tracked& tracked, const VoxelMap& map) const;
  bool is_about_there() const;  // where it was placed last, say the wheels

  DenseMapperSettings settings_;
  Utime last_utime_ = 0;
  Eigen::Isometry3d T_placed_robot_ = Eigen::Isometry3d::Identity();  // by the wheels, since it was placed
  double contradicted_ = 0, unplaced_ = 0;                            // s
  bool carried_ = false, blocked_ = false;
};

}  // namespace lcmslam
