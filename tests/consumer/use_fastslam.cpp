// One update of a landmark, against figures from paper and pencil.

#include <iostream>

#include <lcmslam/fastslam/landmarks/landmark_filter.hpp>
#include <lcmslam/geometry/transform.hpp>

int main() {
  // The robot at (1, 2) looks along the world's y, so that its x is the world's y and its y the world's -x.
  const Eigen::Isometry3d T_world_robot = lcmslam::planar_pose(1, 2, M_PI / 2);
  lcmslam::LandmarkGaussian landmark;
  landmark.mean << 1, 4, 0.5;  // in the robot frame (2, 0, 0.5)
  landmark.covariance = Eigen::Vector3d(0.04, 0.09, 0.01).asDiagonal();
  lcmslam::Measurement measurement;
  measurement.value << 2.2, 0.1, 0.5;
  measurement.covariance = Eigen::Vector3d::Constant(0.01).asDiagonal();

  const lcmslam::LandmarkGaussian updated = update_landmark(
      landmark, innovate(landmark, measurement, T_world_robot), measurement, T_world_robot, 0);

  // Gains along the robot's axes: 0.09 / 0.10, 0.04 / 0.05, 0.01 / 0.02; residual (0.2, 0.1, 0).
  const Eigen::Vector3d mean(1 - 0.8 * 0.1, 4 + 0.9 * 0.2, 0.5);
  const Eigen::Vector3d variances(0.04 * 0.01 / 0.05, 0.09 * 0.01 / 0.10, 0.01 * 0.01 / 0.02);
  const Eigen::Matrix3d covariance = variances.asDiagonal();
  std::cout << "mean " << updated.mean.transpose() << "\n";
  return (updated.mean - mean).norm() < 1e-12 && (updated.covariance - covariance).norm() < 1e-12 ? 0 : 1;
}
