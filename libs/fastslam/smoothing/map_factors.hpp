#pragma once
// The residuals of map_smoother.hpp for Ceres, each in standard deviations.

#include <ceres/ceres.h>
#include <Eigen/Cholesky>

#include <lcmslam/fastslam/landmarks/measurement_model.hpp>
#include <lcmslam/fastslam/pose_space.hpp>

namespace lcmslam {

inline Vector6d twist(const double* xi) {
  return Eigen::Map<const Vector6d>(xi);
}

// Ceres stores row after row, and asks for no Jacobian of what is constant.
template <int rows, int columns>
void store(const Eigen::Matrix<double, rows, columns>& J, double* to) {
  if (to == nullptr) return;
  Eigen::Map<Eigen::Matrix<double, rows, columns, Eigen::RowMajor>> map(to);
  map = J;
}

// L^-1 of the free components' covariance L L^T, other rows 0.
template <int D>
Matrix6d free_root_information(const Matrix6d& covariance) {
  using Matrix = typename PoseSpace<D>::Matrix;
  const Matrix C = PoseSpace<D>::reduce(covariance) + 1e-12 * Matrix::Identity();
  const Matrix root = C.llt().matrixL().solve(Matrix(Matrix::Identity()));
  return PoseSpace<D>::expand(root);
}

// The Jacobians are those at the linearisation by right perturbations: xi and the residual's rotation are
// small (a smoothed path is centimetres from the filter's), and where they vanish nothing is neglected.
class MotionError final : public ceres::SizedCostFunction<6, 6, 6> {
 public:
  MotionError(const Eigen::Isometry3d& A, const Eigen::Isometry3d& B, const Eigen::Isometry3d& Z,
              const Matrix6d& root)
      : A_(A), B_(B), Z_(Z), root_(root) {}

  bool Evaluate(const double* const* xi, double* residuals, double** jacobians) const override {
    const Eigen::Isometry3d between = (A_ * se3_exp(twist(xi[0]))).inverse() * B_ * se3_exp(twist(xi[1]));
    Eigen::Map<Vector6d> residual(residuals);
    residual = root_ * se3_log(Z_.inverse() * between);
    if (jacobians == nullptr) return true;
    store<6, 6>(-root_ * adjoint(between.inverse()), jacobians[0]);
    store<6, 6>(root_, jacobians[1]);
    return true;
  }

 private:
  Eigen::Isometry3d A_, B_, Z_;
  Matrix6d root_;
};

class ObservationError final : public ceres::SizedCostFunction<3, 6, 3> {
 public:
  ObservationError(const Eigen::Isometry3d& T, const Measurement& z)
      : T_(T), z_(z.value), root_(z.covariance.llt().matrixL().solve(Eigen::Matrix3d::Identity().eval())) {}

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Isometry3d T = T_ * se3_exp(twist(parameters[0]));
    const Eigen::Vector3d p = predict_measurement(Eigen::Map<const Eigen::Vector3d>(parameters[1]), T);
    Eigen::Map<Eigen::Vector3d> residual(residuals);
    residual = root_ * (z_ - p);
    if (jacobians == nullptr) return true;
    store<3, 6>(root_ * PoseSpace<6>::residual_jacobian(p), jacobians[0]);
    store<3, 3>(-root_ * T.linear().transpose(), jacobians[1]);
    return true;
  }

 private:
  Eigen::Isometry3d T_;
  Eigen::Vector3d z_;
  Eigen::Matrix3d root_;
};

}  // namespace lcmslam
