#pragma once
// Where a camera sits on a robot, and how large its wheels are, from one drive (hand-eye calibration in the
// plane; after Censi et al. 2013, "Simultaneous calibration of odometry and sensor parameters for mobile
// robots").
//
// A stretch of the drive must be the same whether the wheels or the camera tell it: A X = X B, A of the
// wheels, B of the camera, X = T_robot_camera. Turns tell roll, pitch, x and y, straight ways yaw, both
// together radii and track. A robot that stays in its plane does not tell the camera's height: that comes
// from the floor alone.

#include <optional>

#include <lcmslam/calibration/drive.hpp>

namespace lcmslam {

/// The floor as the depth camera saw it during the drive, in the colour camera's frame.
struct FloorSight {
  Eigen::Vector3d up = Eigen::Vector3d(0, -1, 0);  ///< unit normal
  double height = 0;                               ///< m, of the camera above it
  double up_sigma = 1;                             ///< rad, about each axis
  double height_sigma = 1;                         ///< m
  int images = 0;
};

struct DriveCalibrationSettings {
  // What wheels do that no calibration takes away, by the way rolled (as odometry.wheels has it).
  double translation_drift = 0.01;  ///< m per root metre
  double side_drift = 0.003;  ///< m per root metre, of two wheels on one axle: tyres do not slip sideways
  double rotation_drift = 0.00873;  ///< rad per root metre
  double quantum = 0.001;           ///< m, of a stretch: wheels count in steps
  double flatness = 0.001;          ///< m and rad of a stretch: height, roll and pitch of the ground
  double factor_sigma = 0.1;        ///< of radii and track, before anything is seen
  double kernel = 2.5;              ///< standard deviations: farther off, a wheel slipped
};

struct DriveCalibration {
  Eigen::Isometry3d T_robot_camera = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< T exp(xi): translation (m), then rotation (rad), camera frame
  bool height_observed = false;            ///< false: height is the start's, to a metre by the covariance
  std::vector<double> radius_factors;      ///< true over stated radius, of each wheel
  double layout_factor = 1;                ///< true over stated places of the wheels: the track
  /// Of the radius factors, then the layout factor.
  Eigen::MatrixXd factor_covariance;
  int stretches = 0, slips = 0;  ///< those that were farther off than the kernel
  double way = 0, turned = 0;    ///< m, rad of all stretches
  double misfit = 0;  ///< root mean square of the residuals in standard deviations; 1: as noise says

  /// In the robot's frame: x, y, z, and rotations about its axes.
  Vector6d robot_sigmas() const;
};

/// `start` within some 20 degrees and 20 cm. Throws std::invalid_argument for less than ten stretches, or
/// wheels that differ between them; std::runtime_error where the drive does not tell.
DriveCalibration calibrate_drive(const std::vector<Stretch>& stretches,
                                 const std::optional<FloorSight>& floor, const Eigen::Isometry3d& start,
                                 const DriveCalibrationSettings& settings = {});

}  // namespace lcmslam
