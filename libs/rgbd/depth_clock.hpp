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
  double prior = 0.01;
  /// Frames that follow one another err alike, so it is three times what single frames scatter.
  double noise = 0.03;
  double outlier = 0.1;

  void describe(SettingsVisitor& s) {
    s.flag("enabled", enabled,
           "learns by how much the depth image's stamps are off the colour camera's clock");
    s.number("prior", prior, "s", {1e-4, 1}, "standard deviation of the offset before anything is seen");
    s.number("noise", noise, "rad", {1e-4, 1},
             "standard deviation of the difference between both orientations in one frame");
    s.number("outlier", outlier, "rad", {0, 3.1416}, "a difference beyond is no matter of clocks");
  }
};

class DepthClock {
 public:
  explicit DepthClock(const DepthClockSettings& settings);

  /// One frame: where features and where the cloud, moved in time by offset(), place the robot; omega: its
  /// angular velocity (rad/s, robot frame).
  void add(const Eigen::Isometry3d& T_world_features, const Eigen::Isometry3d& T_world_cloud,
           const Eigen::Vector3d& omega);

  /// s, added to the depth stamp gives the colour camera's clock.
  double offset() const { return offset_; }
  double sigma() const;  ///< s

 private:
  DepthClockSettings settings_;
  double information_ = 0, sum_ = 0;
  double offset_ = 0;
};

}  // namespace lcmslam
