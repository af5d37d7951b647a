#pragma once
// The residuals of path_smoother.hpp for Ceres, each in standard deviations.

#include <ceres/ceres.h>
#include <Eigen/Cholesky>
#include <cmath>

#include <lcmslam/fastslam/landmarks/measurement_model.hpp>
#include <lcmslam/fastslam/odometry_calibration.hpp>

namespace lcmslam {

// L^-1 of a covariance L L^T.
template <class Matrix>
Matrix root_information(const Matrix& covariance) {
  return covariance.llt().matrixL().solve(Matrix::Identity().eval());
}

template <class T>
T wrapped(const T& angle) {
  return angle - 2 * M_PI * ceres::floor((angle + M_PI) / (2 * M_PI));
}

// L^-1 (difference of the relative pose from z exp(J c)), Q = L L^T; right perturbation.
struct OdometryError {
  Eigen::Vector3d z;
  Eigen::Matrix<double, 3, calibration_size> J;
  Eigen::Matrix3d root_information;

  template <class T>
  bool operator()(const T* a, const T* b, const T* c, T* residual) const {
    const T ca = cos(a[2]), sa = sin(a[2]);
    const double cz = std::cos(z.z()), sz = std::sin(z.z());
    const T dx = ca * (b[0] - a[0]) + sa * (b[1] - a[1]) - z.x();
    const T dy = -sa * (b[0] - a[0]) + ca * (b[1] - a[1]) - z.y();
    T e[3] = {cz * dx + sz * dy, -sz * dx + cz * dy, wrapped(T(b[2] - a[2] - z.z()))};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < calibration_size; ++k) e[i] -= J(i, k) * c[k];
    for (int i = 0; i < 3; ++i) {
      residual[i] = T(0);
      for (int k = 0; k <= i; ++k) residual[i] += root_information(i, k) * e[k];
    }
    return true;
  }
};

// `sensor`: offset and scale of the range, offset of the bearing.
struct LandmarkError {
  Measurement z;
  Eigen::Matrix2d root_information;

  template <class T>
  bool operator()(const T* pose, const T* landmark, const T* sensor, T* residual) const {
    const T c = cos(pose[2]), s = sin(pose[2]);
    const T dx = landmark[0] - pose[0], dy = landmark[1] - pose[1];
    const T x = c * dx + s * dy, y = -s * dx + c * dy;
    T e[2] = {z.value.x() - x, z.value.y() - y};
    if (z.kind == MeasurementKind::range_bearing) {
      e[0] = z.value.x() - sensor[0] - (1.0 + sensor[1]) * sqrt(x * x + y * y + 1e-12);
      e[1] = wrapped(T(z.value.y() - sensor[2] - atan2(y, x)));
    }
    residual[0] = root_information(0, 0) * e[0];
    residual[1] = root_information(1, 0) * e[0] + root_information(1, 1) * e[1];
    return true;
  }
};

template <int size>
struct CalibrationPrior {
  Eigen::Matrix<double, size, 1> sigma;
  template <class T>
  bool operator()(const T* c, T* residual) const {
    for (int i = 0; i < size; ++i) residual[i] = c[i] / sigma(i);
    return true;
  }
};

}  // namespace lcmslam
