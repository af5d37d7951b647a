#pragma once
// Where the robot is at each time: a smooth curve in the plane, driven within speed limits.

#include <Eigen/Core>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

struct PathLimits {
  double speed = 0.45;         ///< m/s (pinned limit 0.5: the rest is for the smoothing)
  double turn_rate = 0.9;      ///< rad/s (pinned limit 60 degrees/s = 1.047)
  double acceleration = 0.35;  ///< m/s^2
  double rest = 1.0;           ///< s at standstill at either end
};

/// How a base that can drive sideways turns away from its direction of motion:
/// heading = direction + amplitude * sin(2 pi s / wavelength).
struct HeadingSway {
  double amplitude = 0;   ///< rad
  double wavelength = 6;  ///< m
};

class PlanarPath {
 public:
  /// Clamped uniform cubic B-spline over the control points (at least two, m): continuous curvature.
  /// Throws std::invalid_argument for fewer points or points that coincide.
  explicit PlanarPath(const std::vector<Eigen::Vector2d>& control_points, const PathLimits& limits = {},
                      const HeadingSway& sway = {});

  double length() const { return length_; }      ///< m
  double duration() const;                       ///< s, rests included
  Eigen::Isometry3d pose(double seconds) const;  ///< clamped to 0..duration
  double travelled(double seconds) const;        ///< m of path driven until then

 private:
  Eigen::Vector2d point(double parameter) const;
  Eigen::Vector2d derivative(double parameter) const;
  double parameter_at(double arc_length) const;
  double heading_at(double arc_length) const;
  void measure();
  void schedule(const PathLimits& limits);

  std::vector<Eigen::Vector2d> control_;
  HeadingSway sway_;
  double length_ = 0;
  std::vector<double> arc_length_;  ///< at equal steps of the spline's parameter
  std::vector<double> travelled_;   ///< m at equal steps of time
};

}  // namespace lcmslam
