#include <lcmslam/pose_graph/uncertain_transform.hpp>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace lcmslam {

UncertainTransform operator*(const UncertainTransform& a, const UncertainTransform& b) {
  const Matrix6d A = adjoint(b.T.inverse());
  return {a.T * b.T, A * a.covariance * A.transpose() + b.covariance};
}

UncertainTransform inverse(const UncertainTransform& a) {
  const Matrix6d A = adjoint(a.T);
  return {a.T.inverse(), A * a.covariance * A.transpose()};
}

double distance_from_identity(const UncertainTransform& a) {
  const Vector6d e = se3_log(a.T);
  return std::sqrt(std::max(0.0, e.dot(a.covariance.ldlt().solve(e))));
}

}  // namespace lcmslam
