#pragma once
// A robot on wheels is said to drive on the plane z = 0 of its map. How surely, and when what it measures
// says that it does not (a ramp, a sill): the plane is knowledge like any other, and tested like any other.

#include <Eigen/Dense>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct GroundSettings {
  double height = 0.01;
  double tilt = 0.004;
  double gate = 13.8;
  double return_gate = 4.6;
  int return_after = 10;

  void describe(SettingsVisitor& s) {
    s.number("height", height, "m", {1e-6, 1000},
             "standard deviation of the ground's height under a robot that drives");
    s.number("tilt", tilt, "rad", {1e-6, 3.1416},
             "standard deviation of the ground's tilt under a robot that drives");
    s.number(
        "gate", gate, "", {0.1, 1e9},
        "squared Mahalanobis distance from the plane (99.9 %), beyond which what was measured is believed "
        "instead: of roll and pitch a ramp, of the height another floor");
    s.number("return_gate", return_gate, "", {0, 1e9},
             "squared Mahalanobis distance (90 %), within which a robot that left the plane may be back");
    s.number("return_after", return_after, "", {1, 1e6},
             "steps in a row within return_gate until it is back");
  }
};

/// What is known of the ground under the robot: it is the plane z = 0, it is level but anywhere (a landing, a
/// carpet), or nothing (a ramp).
enum class Floor { plane, level, free };

/// The same pose with no height, roll and pitch.
inline Eigen::Isometry3d on_ground(const Eigen::Isometry3d& T_world_robot) {
  return planar_pose(T_world_robot.translation().x(), T_world_robot.translation().y(), yaw(T_world_robot));
}

/// The same pose with no roll and pitch.
inline Eigen::Isometry3d levelled(const Eigen::Isometry3d& T_world_robot) {
  Eigen::Isometry3d T = on_ground(T_world_robot);
  T.translation().z() = T_world_robot.translation().z();
  return T;
}

/// Height (m), roll and pitch (rad) by which a pose is off the plane: rows 2, 3, 4 of its twist from there.
inline Eigen::Vector3d off_ground(const Eigen::Isometry3d& T_world_robot) {
  return se3_log(on_ground(T_world_robot).inverse() * T_world_robot).segment<3>(2);
}

/// Which floor the robot stands on, from step to step.
class GroundContact {
 public:
  explicit GroundContact(const GroundSettings& settings, Floor floor = Floor::plane)
      : settings_(settings), floor_(floor) {}

  Floor floor() const { return floor_; }

  /// Standard deviations of height, roll and pitch as the floor tells them: m, rad, rad.
  Eigen::Vector3d sigmas() const {
    constexpr double unknown = 1e3;
    return {floor_ == Floor::plane ? settings_.height : unknown,
            floor_ == Floor::free ? unknown : settings_.tilt,
            floor_ == Floor::free ? unknown : settings_.tilt};
  }

  /// The floor that an estimate tells which the floor had no part in (covariance P: right perturbation):
  /// e' (R + P)^-1 e in the gate.
  Floor seen(const Eigen::Isometry3d& T_world_robot, const Matrix6d& covariance) const {
    return told_by(off_ground(T_world_robot), noise() + covariance.block<3, 3>(2, 2), settings_.gate);
  }

  /// The same of an estimate that the floor was part of: what is left of e has the covariance R - P. Where
  /// hardly anything else tells, both vanish; then a quarter of R is taken for their difference.
  Floor left_over(const Eigen::Isometry3d& T_world_robot, const Matrix6d& covariance) const {
    const Eigen::Vector3d s(settings_.height, settings_.tilt, settings_.tilt), t = s.cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> left(
        Eigen::Matrix3d::Identity() - t.asDiagonal() * covariance.block<3, 3>(2, 2) * t.asDiagonal());
    const Eigen::Matrix3d S = left.eigenvectors() * left.eigenvalues().cwiseMax(0.25).asDiagonal() *
                              left.eigenvectors().transpose();
    return told_by(off_ground(T_world_robot), s.asDiagonal() * S * s.asDiagonal(), settings_.gate);
  }

  /// What was measured refuses the floor that was believed.
  void leave_for(Floor floor) {
    floor_ = floor;
    returning_ = 0;
  }

  /// A step later: whether the robot is back on a floor of which more is known, one at a time. What is still
  /// believed of the floor may be part of the estimate.
  void observe(const Eigen::Isometry3d& T_world_robot, const Matrix6d& covariance) {
    const Floor told =
        told_by(off_ground(T_world_robot), noise() + covariance.block<3, 3>(2, 2), settings_.return_gate);
    returning_ = told < floor_ ? returning_ + 1 : 0;
    if (returning_ < settings_.return_after) return;
    floor_ = floor_ == Floor::free ? Floor::level : Floor::plane;
    returning_ = 0;
  }

 private:
  Eigen::Matrix3d noise() const {
    return Eigen::Vector3d(settings_.height, settings_.tilt, settings_.tilt).cwiseAbs2().asDiagonal();
  }
  static Floor told_by(const Eigen::Vector3d& e, const Eigen::Matrix3d& S, double gate) {
    const Eigen::Vector2d tilt = e.tail<2>();
    const Eigen::Matrix2d of_tilt = S.bottomRightCorner<2, 2>();
    if (tilt.dot(of_tilt.ldlt().solve(tilt)) > gate) return Floor::free;
    return e.x() * e.x() > gate * S(0, 0) ? Floor::level : Floor::plane;
  }

  GroundSettings settings_;
  Floor floor_;
  int returning_ = 0;  // steps in a row
};

}  // namespace lcmslam
