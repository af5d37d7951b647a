#include <lcmslam/messages/geometry_messages.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {

rigid_transform_t to_message(const Eigen::Isometry3d& transform) {
  rigid_transform_t message;
  const Eigen::Quaterniond q = Eigen::Quaterniond(transform.linear()).normalized();
  for (int i = 0; i < 3; ++i) message.trans[i] = transform.translation()(i);
  message.quat[0] = q.w();
  message.quat[1] = q.x();
  message.quat[2] = q.y();
  message.quat[3] = q.z();
  return message;
}

Eigen::Isometry3d from_message(const rigid_transform_t& message, const std::string& field) {
  double norm2 = 0;
  for (const double q : message.quat) norm2 += q * q;
  if (!(std::abs(norm2 - 1) < 1e-3)) throw DecodeError(field + ": quaternion is not of unit length");
  for (const double t : message.trans) check_range(t, -largest_coordinate, largest_coordinate, field);
  return make_transform(message.trans, message.quat);
}

Eigen::Isometry3d from_message(const pose_t& message) {
  rigid_transform_t transform;
  std::copy_n(message.pos, 3, transform.trans);
  std::copy_n(message.orientation, 4, transform.quat);
  return from_message(transform, "pose_t");
}

void to_message(const Matrix6d& covariance, double (&values)[36]) {
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> map(values);
  map = covariance;
}

Matrix6d covariance_from_message(const double (&values)[36], const std::string& field) {
  for (const double v : values) check_range(v, -1e12, 1e12, field);
  const Matrix6d covariance = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(values);
  if (covariance.diagonal().minCoeff() < 0) throw DecodeError(field + ": a variance is negative");
  return 0.5 * (covariance + covariance.transpose());
}

void check_range(double value, double low, double high, const std::string& field) {
  if (!(value >= low && value <= high))
    throw DecodeError(field + ": " + std::to_string(value) + " is out of " + std::to_string(low) + ".." +
                      std::to_string(high));
}

}  // namespace lcmslam
