#pragma once
// What the mapper knows before it looks: odometry, or that the robot keeps its velocity, and, for
// wheeled robots, that it stays on the ground.

#include <algorithm>
#include <optional>

#include <lcmslam/geometry/ground_plane.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/registration/solver.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct MotionPriorSettings {
  bool planar = false;  ///< the robot drives on the plane z = 0 of the world; no key: the calibration tells
  double floor_translation = 0.03;
  double floor_rotation = 0.03;
  double free_translation = 0.04;
  double free_rotation = 0.06;
  GroundSettings ground;  ///< that plane; its keys are the mapper's

  void describe(SettingsVisitor& s) {
    s.number(
        "floor_translation", floor_translation, "m", {1e-6, 1000},
        "noise floor of a step, added (squared) to odometry's covariance: wheels slip by more than they "
        "state; less where odometry is surer than along its way and where wheels hardly turn, a tenth at "
        "least; all of it where the map says that a robot that stands was pushed");
    s.number(
        "floor_rotation", floor_rotation, "rad", {1e-6, 3.1416},
        "noise floor of a step, added (squared) to odometry's covariance; a tenth where wheels do not turn");
    s.number("free_translation", free_translation, "m", {1e-6, 1000},
             "how far a step without odometry may differ from constant velocity");
    s.number("free_rotation", free_rotation, "rad", {1e-6, 3.1416},
             "how far a step without odometry may differ from constant velocity");
  }
};

/// Covariance that a prior leaves; of what it says nothing, at most a kilometre.
Matrix6d uncertain(const Prior& prior);

/// What odometry alone has led, since the map last told where the robot is.
struct UnseenWay {
  Matrix6d covariance = Matrix6d::Zero();  ///< of T_world_last by it, robot frame
  double slip = 0;                         ///< of a step's noise floor: the largest share of its steps
};

/// Prior of T_world_robot from the last pose and the motion since: odometry's, or `free_motion` (that of a
/// velocity which goes on) when there is none, and of the floor where the settings are planar. `adrift`: s
/// before, during which nobody knew the motion. `unseen`: on the way to T_world_last.
Prior predict(const Eigen::Isometry3d& T_world_last, const std::optional<Motion>& motion,
              const Eigen::Isometry3d& free_motion, const MotionPriorSettings& settings, double adrift = 0,
              Floor floor = Floor::plane, const UnseenWay& unseen = {});

/// Where the robot was last and how it moved, for the next prediction.
class MotionModel {
 public:
  explicit MotionModel(const MotionPriorSettings& settings) : settings_(settings) {}

  /// Prior of T_world_robot at `utime`, by odometry's `motion` since the last time or, without it, by the
  /// last step's velocity, which goes on for a second at most.
  /// `floor`: what a robot on wheels stands on. `pushed`: wheels that stand do not hold it.
  Prior predict(Utime utime, const std::optional<Motion>& motion, Floor floor = Floor::plane,
                bool pushed = false) const;
  /// The same of this step alone, as if it were known where the robot was last.
  Prior predict_step(Utime utime, const std::optional<Motion>& motion, Floor floor = Floor::plane,
                     bool pushed = false) const;
  /// Whether wheels that hardly turn hold the robot, so that a push leads it elsewhere.
  bool is_held(const std::optional<Motion>& motion) const;

  /// Whether odometry tells how the robot moved. A visual one that is lost guesses: where its step errs by
  /// more than a velocity that goes on, nobody knows.
  bool knows(const std::optional<Motion>& motion) const;

  /// Before predict(): where nobody has known the motion for longer than a velocity goes on, the robot is
  /// adrift until it is found: the prediction is where it was last, and its covariance grows.
  void look_for_gap(Utime utime, const std::optional<Motion>& motion);
  bool adrift() const { return adrift_ > 0; }
  /// What is seen contradicts the map for `seconds`, whatever odometry says: adrift from now on, too.
  void be_carried(double seconds) { adrift_ = std::max(adrift_, seconds); }
  /// How far a robot that is adrift may have gone since it was found: covariance, beside what odometry says.
  Matrix6d drift() const;

  /// Afterwards, by what became of the step: the map tells where the robot is, or its place is as uncertain
  /// as it was and by this motion more; `guided`: badly as the frame fits, it has led the robot.
  void found();
  void lose(Utime utime, const std::optional<Motion>& motion, bool guided = false);

  /// Where the robot is; `moving`: it came there from the last place, so that its velocity may go on.
  void observe(Utime utime, const Eigen::Isometry3d& T_world_robot, bool moving);
  const Eigen::Isometry3d& T_world_last() const { return T_world_last_; }

  /// Where it stands now, by the map; or still, by wheels that hold it (is_held), from where it stood.
  void stand(const Eigen::Isometry3d& T_world_robot) { T_world_stood_ = T_world_robot; }
  const Eigen::Isometry3d& T_world_stood() const { return T_world_stood_; }

  /// The world around the robot moves.
  void deform(const Eigen::Isometry3d& T_new_old) {
    T_world_last_ = T_new_old * T_world_last_;
    T_world_stood_ = T_new_old * T_world_stood_;
  }

 private:
  double seconds_until(Utime utime) const { return static_cast<double>(utime - last_utime_) * 1e-6; }
  Eigen::Isometry3d free_motion(Utime utime) const;

  MotionPriorSettings settings_;
  Utime last_utime_ = 0;
  Eigen::Isometry3d T_world_last_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_world_stood_ = Eigen::Isometry3d::Identity();
  Vector6d velocity_ = Vector6d::Zero();  // per second, robot frame
  double unknown_ = 0;                    // s of motion that nobody knows, since the robot was found
  double adrift_ = 0;                     // s since it may be anywhere, and of what led there
  UnseenWay unseen_;
};

}  // namespace lcmslam
