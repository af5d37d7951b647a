#pragma once
// Something new that goes with a robot that drives: in its view it stays where it is, while all else passes.
// Where wheels spin on the spot all does; nothing that is seen tells the two apart.

#include <memory>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

class VoxelMap;

class Companion {
 public:
  Companion();
  ~Companion();

  /// A cloud (robot frame) of which a good part seems to go with the robot.
  void begin(const Cloud& cloud);
  void end();
  bool there() const { return seen_ != nullptr; }
  /// The next cloud, and how wheels have led the robot there: ends where the view passes.
  void observe(const Cloud& cloud, const Motion& motion);

 private:
  std::unique_ptr<VoxelMap> seen_;  // robot frame, then; null: nothing goes with it
  Eigen::Isometry3d T_seen_now_ = Eigen::Isometry3d::Identity();  // by wheels
};

}  // namespace lcmslam
