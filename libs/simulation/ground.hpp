#pragma once
// What lies on a scene's floor and wheels climb (ramps, sills, carpets), and how a robot stands on it.

#include <Eigen/Geometry>
#include <vector>

namespace lcmslam {

/// A line of heights drawn sideways: piecewise linear along its own x axis, alike over its width.
struct GroundProfile {
  Eigen::Isometry2d T_world_profile = Eigen::Isometry2d::Identity();
  double width = 1;                     ///< m, half of it to each side of the x axis
  std::vector<Eigen::Vector2d> points;  ///< m: way along x, ascending; height above the floor, not negative
};

/// A wheel that carries the robot, in the robot's frame: m.
struct CarryingWheel {
  double x = 0, y = 0, radius = 0.1;
};

class Ground {
 public:
  Ground() = default;  ///< the flat floor z = 0
  /// Throws std::invalid_argument for a profile of fewer than two points, or whose points do not ascend.
  explicit Ground(std::vector<GroundProfile> profiles);

  bool is_flat() const { return profiles_.empty(); }
  /// m above z = 0, of the highest that lies there.
  double height(const Eigen::Vector2d& place) const;
  /// m: how high a wheel stands that rolls along `forward` (a unit vector). It touches what it meets first,
  /// which on an edge is before or behind its hub.
  double height_of_wheel(const Eigen::Vector2d& place, const Eigen::Vector2d& forward, double radius) const;

 private:
  std::vector<GroundProfile> profiles_;
};

/// Where a robot stands that is at T_floor (x, y, heading) seen from above. It hangs on equal springs over
/// its wheels: its frame is their contacts' least-squares plane, its x axis seen from above keeps the
/// heading. On the flat floor, or without wheels, T_floor itself.
Eigen::Isometry3d stand_on(const Ground& ground, const std::vector<CarryingWheel>& wheels,
                           const Eigen::Isometry3d& T_floor);

}  // namespace lcmslam
