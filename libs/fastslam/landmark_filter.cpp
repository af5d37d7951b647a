#include "fastslam/landmark_filter.hpp"

#include <Eigen/LU>
#include <cmath>

namespace lcmslam {
namespace {

constexpr double kTwoPi = 6.283185307179586;

// A B A^T, exactly symmetric.
Eigen::Matrix3d sandwiched(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  const Eigen::Matrix3d C = A * B * A.transpose();
  return 0.5 * (C + C.transpose());
}

template <class Model>
Innovation innovate_as(const LandmarkGaussian& landmark, const Measurement& measurement,
                       const Eigen::Isometry3d& T_world_robot) {
  Innovation result;
  result.predicted = predict_measurement(landmark.mean, T_world_robot);
  result.residual = Model::difference(measurement.value, Model::predict(result.predicted));
  result.landmark = sandwiched(T_world_robot.linear().transpose(), landmark.covariance);
  if constexpr (Model::dimension < 3)
    result.landmark = sandwiched(Model::jacobian(result.predicted), result.landmark);
  const Eigen::Matrix3d S = result.landmark + measurement.covariance;
  result.inverse = S.inverse();
  result.distance2 = result.residual.dot(result.inverse * result.residual);
  constexpr double scale = Model::dimension == 3 ? kTwoPi * kTwoPi * kTwoPi : kTwoPi * kTwoPi;
  result.log_peak = -0.5 * std::log(scale * S.determinant());
  return result;
}

// Joseph's form, (I - K G) P (I - K G)^T + K R_z K^T: positive for every G, also one without an inverse.
template <class Model>
LandmarkGaussian update_as(const LandmarkGaussian& landmark, const Innovation& innovation,
                           const Measurement& measurement, const Eigen::Matrix3d& R) {
  const Eigen::Matrix3d P = sandwiched(R.transpose(), landmark.covariance);
  const Eigen::Matrix3d G = Model::jacobian(innovation.predicted);
  const Eigen::Matrix3d gain = P * G.transpose() * innovation.inverse;
  const Eigen::Matrix3d kept = Eigen::Matrix3d::Identity() - gain * G;
  return {landmark.mean + R * (gain * innovation.residual),
          sandwiched(R, sandwiched(kept, P) + sandwiched(gain, measurement.covariance))};
}

// G = I, and P - P S^-1 P = P S^-1 R_z: no difference of large numbers, stays positive over any number
// of updates, and is the cheaper form.
template <>
LandmarkGaussian update_as<PointModel>(const LandmarkGaussian& landmark, const Innovation& innovation,
                                       const Measurement& measurement, const Eigen::Matrix3d& R) {
  const Eigen::Matrix3d gain = innovation.landmark * innovation.inverse;
  return {landmark.mean + R * (gain * innovation.residual), sandwiched(R, gain * measurement.covariance)};
}

}  // namespace

Eigen::Matrix3d innovation_covariance(const LandmarkGaussian& landmark, const Measurement& measurement,
                                      const Eigen::Isometry3d& T_world_robot) {
  const Eigen::Matrix3d& R = T_world_robot.linear();
  const Eigen::Matrix3d P = R.transpose() * landmark.covariance * R;
  if (measurement.kind == MeasurementKind::point) return P + measurement.covariance;
  const Eigen::Vector3d p = predict_measurement(landmark.mean, T_world_robot);
  const Eigen::Matrix3d G =
      with_model(measurement.kind, [&](auto model) -> Eigen::Matrix3d { return model.jacobian(p); });
  return G * P * G.transpose() + measurement.covariance;
}

Innovation innovate(const LandmarkGaussian& landmark, const Measurement& measurement,
                    const Eigen::Isometry3d& T_world_robot) {
  return with_model(measurement.kind, [&](auto model) {
    return innovate_as<decltype(model)>(landmark, measurement, T_world_robot);
  });
}

LandmarkGaussian make_landmark(const Measurement& measurement, const Eigen::Isometry3d& T_world_robot) {
  const RobotPoint p =
      with_model(measurement.kind, [&](auto model) { return model.initialise(measurement); });
  return {T_world_robot * p.position, sandwiched(T_world_robot.linear(), p.covariance)};
}

LandmarkGaussian update_landmark(const LandmarkGaussian& landmark, const Innovation& innovation,
                                 const Measurement& measurement, const Eigen::Isometry3d& T_world_robot,
                                 double added_variance) {
  return with_model(measurement.kind, [&](auto model) {
    using Model = decltype(model);
    LandmarkGaussian result = update_as<Model>(landmark, innovation, measurement, T_world_robot.linear());
    result.covariance.diagonal().template head<Model::dimension>().array() += added_variance;
    return result;
  });
}

}  // namespace lcmslam
