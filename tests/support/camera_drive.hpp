#pragma once
// A drive of which wheels count and a camera sees, without any image: the camera's motion is the true one
// with noise.

#include <lcmslam/calibration/drive_calibration.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/simulation/wheel_base.hpp>

namespace lcmslam::testing {

/// Figures of eight, 5 m x 1.8 m by `scale`, and between them a straight way: turns to both sides.
inline PlanarPath figure_of_eight(int laps, double scale = 1) {
  std::vector<Eigen::Vector2d> points;
  for (int lap = 0; lap < laps; ++lap)
    for (const auto& p : {Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0.9), Eigen::Vector2d(2, 0.9),
                          Eigen::Vector2d(2.5, 0), Eigen::Vector2d(2, -0.9), Eigen::Vector2d(1, -0.9),
                          Eigen::Vector2d(0, 0.05), Eigen::Vector2d(-1, 0.9), Eigen::Vector2d(-2, 0.9),
                          Eigen::Vector2d(-2.5, 0), Eigen::Vector2d(-2, -0.9), Eigen::Vector2d(-1, -0.9)})
      points.emplace_back(scale * p);
  return PlanarPath(points);
}

struct CameraNoise {
  double translation = 0.001;  ///< m a frame
  double rotation = 0.0004;    ///< rad a frame
};

/// Poses of the camera at 10 Hz, errors accumulated as visual odometry does.
inline std::vector<MotionSample> seen_motion(const DrivenPath& path, const Eigen::Isometry3d& T_robot_camera,
                                             Utime start, std::uint64_t seed, const CameraNoise& noise = {}) {
  Random random(seed, 31);
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(noise.translation), Eigen::Vector3d::Constant(noise.rotation);
  std::vector<MotionSample> samples;
  const Eigen::Isometry3d first = path.pose(0) * T_robot_camera;
  Eigen::Isometry3d before = first;
  MotionSample sample;
  for (double t = 0; t <= path.duration(); t += 0.1) {
    const Eigen::Isometry3d now = path.pose(t) * T_robot_camera;
    Vector6d error;
    for (int i = 0; i < 6; ++i) error[i] = random.normal(0, sigma[i]);
    const Eigen::Isometry3d step = before.inverse() * now * se3_exp(error);
    const Matrix6d A = adjoint(step.inverse());
    sample.utime = start + static_cast<Utime>(std::llround(1e6 * t));
    sample.T_odom_robot = sample.T_odom_robot * step;
    sample.covariance = A * sample.covariance * A.transpose();
    sample.covariance.diagonal() += sigma.cwiseAbs2();
    samples.push_back(sample);
    before = now;
  }
  return samples;
}

}  // namespace lcmslam::testing
