#pragma once
// The path and the map of 3-D landmarks again, from all that the best particle took for seen: a pose graph
// with landmarks, on request and for the final map. (Landmarks of known identity in the plane have the
// path_smoother.hpp, which also gives the filter new particles.)
//
//   sum |log(Z^-1 T_a^-1 T_b)|^2_Q + sum rho(|z - R^T (m - t)|^2_R),   T = T_estimated exp(xi)
//
// Keyframes stand where the robot moved on since the last one, and where it has been no more than once. So
// they grow with the area that it has seen and not with the time or the way, and where they get too many they
// stand farther apart: memory and the solver's time are bounded. The first one is held: the world stays the
// filter's.

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <lcmslam/fastslam/landmarks/measurement_model.hpp>
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/fastslam/smoothing/path_smoother.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

struct PointObservation {
  std::int64_t landmark = 0;  ///< id that is never used twice
  Measurement measurement;    ///< of kind point
};

struct MapSmoothing {
  std::vector<SmoothedPose> path;                     ///< of the keyframes
  std::map<std::int64_t, Eigen::Vector3d> landmarks;  ///< those of two observations or more; m, world
  Eigen::Isometry3d T_world_correction = Eigen::Isometry3d::Identity();  ///< T_smoothed = T * T_estimated,
                                                                         ///< at the newest keyframe
  double cost_before = 0, cost_after = 0;                                ///< half the weighted squares
  std::size_t residuals = 0;
};

class MapSmoother {
 public:
  explicit MapSmoother(const FastSlamSettings& settings) : settings_(settings) {}

  /// The keyframes have six degrees of freedom from now on.
  void leave_plane(const FastSlamSettings& settings) { settings_ = settings; }

  /// A step of the filter. `T_world_robot`: the best particle's; `motion`: to it from the step before, with
  /// the noise that the filter gives it; nothing where the robot was put elsewhere. `loop_closed`: the pose
  /// is that of a place recognised, and the motion leads from where drift had put the robot.
  void add(Utime utime, const Eigen::Isometry3d& T_world_robot, const std::optional<Motion>& motion,
           const std::vector<PointObservation>& seen, bool loop_closed = false);

  /// Minimises over all keyframes. Changes nothing here: a copy may be solved beside the filter. Nothing
  /// with fewer than two keyframes.
  std::optional<MapSmoothing> solve() const;

  /// The filter stands where the smoothed path leads: the keyframes do so too, and those that were added
  /// since it was solved stand where it carries them.
  void take_over(const MapSmoothing& smoothed);

  std::size_t keyframes() const { return keyframes_.size(); }
  static constexpr std::size_t maximum_keyframes = 200;  ///< a second or two for the solver

 private:
  struct Keyframe {
    Utime utime = 0;
    Eigen::Isometry3d T_world_robot;
    std::optional<Motion> motion;  // from the keyframe before
    std::vector<PointObservation> seen;
    bool loop_closed = false;
  };
  bool known_from(const Eigen::Isometry3d& T_world_robot) const;
  void thin();
  std::vector<Eigen::Isometry3d> deformed_path() const;

  FastSlamSettings settings_;
  double spacing_ = 0.05;  // m and rad, between keyframes
  std::vector<Keyframe> keyframes_;
  std::optional<Motion> motion_;  // since the newest keyframe
  bool loop_closed_ = false;      // since then
};

}  // namespace lcmslam
