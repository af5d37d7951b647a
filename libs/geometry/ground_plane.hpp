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
  double gate = 16.3;
  double return_gate = 2.4;
  int return_after = 10;

  void describe(SettingsVisitor& s) {
    s.number("height", height, "m", {1e-6, 1000},
             "standard deviation of the ground's height under a robot that drives");
    s.number("tilt", tilt, "rad", {1e-6, 3.1416},
             "standard deviation of the ground's tilt under a robot that drives");
    s.number(
        "gate", gate, "", {0.1, 1e9},
        "squared Mahalanobis distance (height, roll, pitch; 99.9 %) from the plane, beyond which what was "
        "measured is believed instead: a ramp");
    s.number(
        "return_gate", return_gate, "", {0, 1e9},
        "squared Mahalanobis distance (50 %) from the plane, within which a robot that left it may be back");
    s.number("return_after", return_after, "", {1, 1e6},
             "steps in a row within return_gate until it is back");
  }
};

/// The same pose with no height, roll and pitch.
inline Eigen::Isometry3d on_ground(const Eigen::Isometry3d& T_world_robot) {
  return planar_pose(T_world_robot.translation().x(), T_world_robot.translation().y(), yaw(T_world_robot));
}

/// Height (m), roll and pitch (rad) by which a pose is off the plane: rows 2, 3, 4 of its twist from there.
inline Eigen::Vector3d off_ground(const Eigen::Isometry3d& T_world_robot) {
  return se3_log(on_ground(T_world_robot).inverse() * T_world_robot).segment<3>(2);
}

/// Whether the plane still holds, from step to step.
class GroundContact {
 public:
  explicit GroundContact(const GroundSettings& settings) : settings_(settings) {}

  bool holds() const { return holds_; }

  /// An estimate with its covariance (right perturbation) that the plane had no part in: e' (R + P)^-1 e.
  double innovation2(const Eigen::Isometry3d& T_world_robot, const Matrix6d& covariance) const {
    const Eigen::Vector3d e = in_sigmas(off_ground(T_world_robot));
    return e.dot((Eigen::Matrix3d::Identity() + in_sigmas(covariance)).ldlt().solve(e));
  }

  /// One that it was part of: what is left of e has the covariance R - P. Where hardly anything but the plane
  /// tells, both vanish; then a quarter of R is taken for their difference.
  double residual2(const Eigen::Isometry3d& T_world_robot, const Matrix6d& covariance) const {
    const Eigen::Vector3d e = in_sigmas(off_ground(T_world_robot));
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> left(Eigen::Matrix3d::Identity() -
                                                              in_sigmas(covariance));
    return (left.eigenvectors().transpose() * e)
        .array()
        .square()
        .matrix()
        .dot(left.eigenvalues().cwiseMax(0.25).cwiseInverse());
  }

  bool is_refused(double distance2) const { return distance2 > settings_.gate; }

  /// What was measured refuses the plane.
  void leave() {
    holds_ = false;
    returning_ = 0;
  }

  /// A step off the plane, with an estimate that it had no part in.
  void observe(const Eigen::Isometry3d& T_world_robot, const Matrix6d& covariance) {
    if (holds_) return;
    returning_ = innovation2(T_world_robot, covariance) < settings_.return_gate ? returning_ + 1 : 0;
    holds_ = returning_ >= settings_.return_after;
  }

 private:
  Eigen::Vector3d sigmas() const { return {settings_.height, settings_.tilt, settings_.tilt}; }
  Eigen::Vector3d in_sigmas(const Eigen::Vector3d& e) const { return e.cwiseQuotient(sigmas()); }
  Eigen::Matrix3d in_sigmas(const Matrix6d& covariance) const {
    const Eigen::Vector3d s = sigmas().cwiseInverse();
    return s.asDiagonal() * covariance.block<3, 3>(2, 2) * s.asDiagonal();
  }

  GroundSettings settings_;
  bool holds_ = true;
  int returning_ = 0;  // steps in a row
};

}  // namespace lcmslam
