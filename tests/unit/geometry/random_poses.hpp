#pragma once
// Random transforms and point sets for property tests. The seed goes into SCOPED_TRACE.

#include <vector>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

inline Eigen::Vector3d random_vector(Random& random, double sigma) {
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

/// Rotation angle uniform below max_angle, translation normal.
inline Eigen::Isometry3d random_transform(Random& random, double max_angle = 3.1, double sigma = 1) {
  Vector6d twist;
  twist.head<3>() = random_vector(random, sigma);
  twist.tail<3>() = random.uniform(0, max_angle) * random_vector(random, 1).normalized();
  return se3_exp(twist);
}

inline Matrix6d random_covariance(Random& random, double scale) {
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = random.normal(0, scale);
  return A * A.transpose();
}

inline std::vector<Eigen::Vector3d> moved(const std::vector<Eigen::Vector3d>& points,
                                          const Eigen::Isometry3d& T) {
  std::vector<Eigen::Vector3d> result;
  for (const auto& p : points) result.push_back(T * p);
  return result;
}

}  // namespace lcmslam
