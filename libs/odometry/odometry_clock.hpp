#pragma once
// By how much odometry's stamps are off the camera's clock, from the motion itself: both turn alike (Kelly
// and Sukhatme 2014). Between every two images the camera turned by some rotation vector; odometry's, taken a
// little earlier or later, must be the same one in another frame and to a scale. The offset at which they are
// most alike is the clocks'. Needs no mount.

#include <optional>
#include <string>
#include <vector>

#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct OdometryClockSettings {
  double range = 0.5, step = 0.01;
  double longest_step = 0.5;
  double least_turn = 0.5;
  double outlier = 4;
  double correlation = 4;
  double largest_sigma = 0.005;

  void describe(SettingsVisitor& s) {
    s.number("range", range, "s", {0.01, 10}, "that offsets are looked for, both ways");
    s.number("step", step, "s", {1e-3, 1}, "between offsets that are tried first");
    s.number("longest_step", longest_step, "s", {0.01, 10}, "between images that are compared");
    s.number("least_turn", least_turn, "rad", {0.01, 100}, "in all, before anything is said");
    s.number("outlier", outlier, "", {1, 100}, "scales of a difference, beyond which a step is left out");
    s.number("correlation", correlation, "", {1, 100}, "on the sigma: neighbouring steps share their errors");
    s.number("largest_sigma", largest_sigma, "s", {1e-4, 1}, "of an offset that is worth saying");
  }
};

class OdometryClock {
 public:
  explicit OdometryClock(const OdometryClockSettings& settings = {});

  /// In the order of their stamps; an older one begins anew.
  void add_camera(Utime utime, const Eigen::Isometry3d& T_world_camera);
  /// The same as a step: the rotation vector of R_from_to, rad, camera frame.
  void add_camera_step(Utime from, Utime to, const Eigen::Vector3d& turn);
  void add_odometry(const MotionSample& sample);

  struct Offset {
    bool known = false;
    std::string reason;   ///< why not
    double offset = 0;    ///< s, added to odometry's stamps gives the camera's clock
    double sigma = 0;     ///< s
    double scale = 1;     ///< of the camera's turns by odometry's
    double likeness = 0;  ///< correlation of both, 1: equal but for a scale
    int steps = 0;        ///< that were compared
  };
  Offset estimate() const;

 private:
  struct CameraStep {
    Utime from, to;
    Eigen::Vector3d turn;
  };
  struct Likeness;
  bool is_covered(Utime from, Utime to) const;
  std::optional<Eigen::Quaterniond> odometry_at(Utime utime) const;
  std::optional<Eigen::Vector3d> odometry_turn(Utime from, Utime to) const;
  Utime period() const;
  std::optional<Eigen::Vector3d> odometry_turn_around(Utime from, Utime to) const;
  std::optional<Likeness> compare(double offset, const std::vector<CameraStep>& steps) const;

  OdometryClockSettings settings_;
  std::vector<CameraStep> steps_;
  Utime last_utime_ = 0;
  Eigen::Isometry3d T_world_last_ = Eigen::Isometry3d::Identity();
  std::vector<std::pair<Utime, Eigen::Quaterniond>> odometry_;  // orientations
};

}  // namespace lcmslam
