#pragma once
// What a sensor says of a landmark, behind one interface. Every sensor here measures the landmark as it
// stands in the robot frame, p = R^T (m - t), so a model is a function g of p alone:
//
//   z = g(p) + noise,   dz/dm = G R^T,   dz/dxi = -G [I, -hat(p)],   G = dg/dp,   pose T exp(xi)
//
// and the filter's Jacobians follow from G in one place. A model has
//   dimension         components of z that are measured; beyond them z is 0 and G's rows are 0
//   predict(p)        g(p)
//   jacobian(p)       G
//   difference(z, h)  z - h, angles wrapped to [-pi, pi]
//   initialise(m)     p and its covariance from one measurement
//
// Measurements of two components live in three: the third is 0 with variance 1 and says nothing, so that
// one type and one filter serve all, and no matrix is singular. Landmarks of planar sensors stand in the
// robot's ground plane, z = 0.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include <lcmslam/fastslam/pose_space.hpp>
#include <lcmslam/features/feature.hpp>

namespace lcmslam {

struct Measurement {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();           ///< m, rad: what `kind` says
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of value; 1 where nothing is measured
  MeasurementKind kind = MeasurementKind::point;
  /// Of a bearing: where the camera sits. Borrowed from the FeatureFrame, which must live as long.
  const Eigen::Isometry3d* T_robot_camera = nullptr;
};

/// A position with its covariance, in the robot frame.
struct RobotPoint {
  Eigen::Vector3d position;    ///< m
  Eigen::Matrix3d covariance;  ///< m^2
};

/// Variance of a planar landmark's height, m^2: it stands in the plane by definition.
constexpr double plane_variance = 1e-6;

/// (x, y, z) m in the robot frame (thesis 2.6-2.8).
struct PointModel {
  static constexpr int dimension = 3;
  static Eigen::Vector3d predict(const Eigen::Vector3d& p) { return p; }
  static Eigen::Matrix3d jacobian(const Eigen::Vector3d&) { return Eigen::Matrix3d::Identity(); }
  static Eigen::Vector3d difference(const Eigen::Vector3d& z, const Eigen::Vector3d& h) { return z - h; }
  static RobotPoint initialise(const Measurement& m) { return {m.value, m.covariance}; }
};

/// (x, y) m in the robot frame.
struct PlanarModel {
  static constexpr int dimension = 2;
  static Eigen::Vector3d predict(const Eigen::Vector3d& p) { return {p.x(), p.y(), 0}; }
  static Eigen::Matrix3d jacobian(const Eigen::Vector3d&) { return Eigen::Vector3d(1, 1, 0).asDiagonal(); }
  static Eigen::Vector3d difference(const Eigen::Vector3d& z, const Eigen::Vector3d& h) { return z - h; }
  static RobotPoint initialise(const Measurement& m) {
    RobotPoint p{m.value, m.covariance};
    p.covariance(2, 2) = plane_variance;
    return p;
  }
};

/// (range m, bearing rad from x towards y) in the robot's plane.
struct RangeBearingModel {
  static constexpr int dimension = 2;
  static Eigen::Vector3d predict(const Eigen::Vector3d& p) {
    return {std::hypot(p.x(), p.y()), std::atan2(p.y(), p.x()), 0};
  }
  /// Undefined on the robot itself: nearer than 1 cm the Jacobian is that of 1 cm.
  static Eigen::Matrix3d jacobian(const Eigen::Vector3d& p) {
    const double range = std::max(0.01, std::hypot(p.x(), p.y()));
    const double cosine = p.x() / range, sine = p.y() / range;
    Eigen::Matrix3d G;
    G << cosine, sine, 0, -sine / range, cosine / range, 0, 0, 0, 0;
    return G;
  }
  static Eigen::Vector3d difference(const Eigen::Vector3d& z, const Eigen::Vector3d& h) {
    return {z.x() - h.x(), std::remainder(z.y() - h.y(), 2 * M_PI), 0};
  }
  static RobotPoint initialise(const Measurement& m) {
    const double range = m.value.x(), cosine = std::cos(m.value.y()), sine = std::sin(m.value.y());
    Eigen::Matrix3d J;  // dp/dz
    J << cosine, -range * sine, 0, sine, range * cosine, 0, 0, 0, 0;
    RobotPoint p{{range * cosine, range * sine, 0}, J * m.covariance * J.transpose()};
    p.covariance(2, 2) = plane_variance;
    return p;
  }
};

/// (x / z, y / z) in the camera frame: where a pixel looks, without depth. Measures landmarks that are known
/// from elsewhere; makes none.
struct BearingModel {
  static constexpr int dimension = 2;
  const Eigen::Isometry3d* T_robot_camera;

  Eigen::Vector3d in_camera(const Eigen::Vector3d& p) const {
    return T_robot_camera->linear().transpose() * (p - T_robot_camera->translation());
  }
  /// What lies behind the camera is predicted far outside every image, and nothing is learned from it.
  static bool behind(const Eigen::Vector3d& q) { return q.z() < 0.01; }
  Eigen::Vector3d predict(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d q = in_camera(p);
    if (behind(q)) return {1e6, 1e6, 0};
    return {q.x() / q.z(), q.y() / q.z(), 0};
  }
  Eigen::Matrix3d jacobian(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d q = in_camera(p);
    if (behind(q)) return Eigen::Matrix3d::Zero();
    Eigen::Matrix3d by_q;
    by_q << 1, 0, -q.x() / q.z(), 0, 1, -q.y() / q.z(), 0, 0, 0;
    return by_q / q.z() * T_robot_camera->linear().transpose();
  }
  static Eigen::Vector3d difference(const Eigen::Vector3d& z, const Eigen::Vector3d& h) { return z - h; }
};

/// Calls function(model) with the model of `kind` (not of bearings, which need more than their kind): a
/// switch outside, straight code inside.
template <class Function>
auto with_model(MeasurementKind kind, Function&& function) {
  if (kind == MeasurementKind::planar) return function(PlanarModel());
  if (kind == MeasurementKind::range_bearing) return function(RangeBearingModel());
  return function(PointModel());
}

/// The same with the model of a measurement.
template <class Function>
auto with_model(const Measurement& measurement, Function&& function) {
  if (measurement.kind == MeasurementKind::bearing) return function(BearingModel{measurement.T_robot_camera});
  return with_model(measurement.kind, function);
}

/// h(m): the landmark's position in the robot frame.
inline Eigen::Vector3d predict_measurement(const Eigen::Vector3d& mean,
                                           const Eigen::Isometry3d& T_world_robot) {
  return T_world_robot.linear().transpose() * (mean - T_world_robot.translation());
}

/// What the sensor of `kind` should measure of a landmark.
inline Eigen::Vector3d predict_measurement(MeasurementKind kind, const Eigen::Vector3d& mean,
                                           const Eigen::Isometry3d& T_world_robot) {
  const Eigen::Vector3d p = predict_measurement(mean, T_world_robot);
  return with_model(kind, [&](auto model) -> Eigen::Vector3d { return model.predict(p); });
}

/// d residual / d xi of a measurement whose landmark stands at p in the robot frame: G [I, -hat(p)].
template <int D>
typename PoseSpace<D>::Jacobian residual_jacobian(MeasurementKind kind, const Eigen::Vector3d& p) {
  const typename PoseSpace<D>::Jacobian J = PoseSpace<D>::residual_jacobian(p);
  if (kind == MeasurementKind::point) return J;
  const Eigen::Matrix3d G =
      with_model(kind, [&](auto model) -> Eigen::Matrix3d { return model.jacobian(p); });
  return G * J;
}

template <int D>
typename PoseSpace<D>::Jacobian residual_jacobian(const Measurement& measurement, const Eigen::Vector3d& p) {
  const typename PoseSpace<D>::Jacobian J = PoseSpace<D>::residual_jacobian(p);
  if (measurement.kind == MeasurementKind::point) return J;
  const Eigen::Matrix3d G =
      with_model(measurement, [&](auto model) -> Eigen::Matrix3d { return model.jacobian(p); });
  return G * J;
}

}  // namespace lcmslam
