#pragma once
// By how much the depth image's stamp is off the colour camera's clock, from the motion itself: features
// place the robot at the colour image's time, the cloud at the depth image's. Where the robot turns with
// omega, both differ by omega times what the stamps are off; least squares over the turns tell it (after
// Kelly and Sukhatme 2014, who align curves of rotation alike).

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct DepthClockSettings {
  bool enabled = true;
  double prior = 0.003;
  double noise = 0.01;
  double stated_frames = 30;
  double frames_alike = 16;
  double outlier = 0.1;

  void describe(SettingsVisitor& s) {
    s.flag("enabled", enabled,
           "learns by how much the depth image's stamps are off the colour camera's clock");
    s.number("prior", prior, "s", {1e-4, 1}, "standard deviation of the offset before anything is seen");
    s.number(
        "noise", noise, "rad", {1e-4, 1},
        "standard deviation of the difference between both orientations in one frame, before any is seen");
    s.number("stated_frames", stated_frames, "", {0.1, 1e6},
             "as many as noise counts for beside the differences that are seen");
    s.number("frames_alike", frames_alike, "", {1, 1e6},
             "frames in a row whose difference is as good as the same, and counts once");
    s.number("outlier", outlier, "rad", {0, 3.1416}, "a difference beyond is no matter of clocks");
  }
};

class DepthClock {
 public:
  explicit DepthClock(const DepthClockSettings& settings);

  /// One frame: where features and where the cloud place the robot; omega: its angular velocity (rad/s, robot
  /// frame); `added`: s, to the depth stamp, when the cloud was moved in time (offset() where it was moved).
  void add(const Eigen::Isometry3d& T_world_features, const Eigen::Isometry3d& T_world_cloud,
           const Eigen::Vector3d& omega, double added);

  /// s, added to the depth stamp gives the colour camera's clock.
  double offset() const { return offset_; }
  double sigma() const;  ///< s

 private:
  double information() const;  // prior and turns, 1/s^2

  DepthClockSettings settings_;
  // Of each frame's turn (rad) had nothing been moved in time, and its omega.
  double frames_ = 0, omega_omega_ = 0, omega_turn_ = 0, turn_turn_ = 0;
  double variance_;  // rad^2, of one frame's turn
  double offset_ = 0;
};

}  // namespace lcmslam
