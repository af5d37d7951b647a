#include <lcmslam/fastslam/landmarks/landmark_filter.hpp>

#include <cmath>
#include <stdexcept>

#include <lcmslam/fastslam/landmarks/symmetric.hpp>

namespace lcmslam {
namespace {

constexpr double two_pi = 6.283185307179586;

template <class Model>
Innovation innovate_as(const Model& model, const LandmarkGaussian& landmark, const Measurement& measurement,
                       const Eigen::Isometry3d& T_world_robot) {
  Innovation result;
  result.predicted = predict_measurement(landmark.mean, T_world_robot);
  result.residual = model.difference(measurement.value, model.predict(result.predicted));
  result.landmark = sandwiched(T_world_robot.linear().transpose(), landmark.covariance);
  if constexpr (Model::dimension < 3)
    result.landmark = sandwiched(model.jacobian(result.predicted), result.landmark);
  const Eigen::Matrix3d S = result.landmark + measurement.covariance;
  const SymmetricInverse inverse = invert_symmetric(S);
  result.inverse = inverse.inverse;
  result.distance2 = result.residual.dot(result.inverse * result.residual);
  constexpr double scale = Model::dimension == 3 ? two_pi * two_pi * two_pi : two_pi * two_pi;
  result.log_peak = -0.5 * std::log(scale * inverse.determinant);
  return result;
}

// Joseph's form, (I - K G) P (I - K G)^T + K R_z K^T: positive for every G, also one without an inverse.
template <class Model>
LandmarkGaussian update_as(const Model& model, const LandmarkGaussian& landmark, const Innovation& innovation,
                           const Measurement& measurement, const Eigen::Matrix3d& R) {
  const Eigen::Matrix3d P = sandwiched(R.transpose(), landmark.covariance);
  const Eigen::Matrix3d G = model.jacobian(innovation.predicted);
  const Eigen::Matrix3d gain = P * G.transpose() * innovation.inverse;
  const Eigen::Matrix3d kept = Eigen::Matrix3d::Identity() - gain * G;
  return {landmark.mean + R * (gain * innovation.residual),
          sandwiched(R, sandwiched(kept, P) + sandwiched(gain, measurement.covariance))};
}

// G = I, and P - P S^-1 P = P S^-1 R_z: no difference of large numbers, stays positive over any number of
// updates, and is the cheaper form.
LandmarkGaussian update_as(const PointModel&, const LandmarkGaussian& landmark, const Innovation& innovation,
                           const Measurement& measurement, const Eigen::Matrix3d& R) {
  const Eigen::Matrix3d gain = innovation.landmark * innovation.inverse;
  return {landmark.mean + R * (gain * innovation.residual),
          sandwiched(R, symmetric_product(gain, measurement.covariance))};
}

}  // namespace

Eigen::Matrix3d innovation_covariance(const LandmarkGaussian& landmark, const Measurement& measurement,
                                      const Eigen::Isometry3d& T_world_robot) {
  const Eigen::Matrix3d& R = T_world_robot.linear();
  const Eigen::Matrix3d P = sandwiched(R.transpose(), landmark.covariance);
  if (measurement.kind == MeasurementKind::point) return P + measurement.covariance;
  const Eigen::Vector3d p = predict_measurement(landmark.mean, T_world_robot);
  const Eigen::Matrix3d G =
      with_model(measurement, [&](auto model) -> Eigen::Matrix3d { return model.jacobian(p); });
  return G * P * G.transpose() + measurement.covariance;
}

Innovation innovate(const LandmarkGaussian& landmark, const Measurement& measurement,
                    const Eigen::Isometry3d& T_world_robot) {
  return with_model(measurement,
                    [&](auto model) { return innovate_as(model, landmark, measurement, T_world_robot); });
}

LandmarkGaussian make_landmark(const Measurement& measurement, const Eigen::Isometry3d& T_world_robot) {
  if (measurement.kind == MeasurementKind::bearing)
    throw std::invalid_argument("make_landmark: a bearing alone makes no landmark");
  const RobotPoint p =
      with_model(measurement.kind, [&](auto model) { return model.initialise(measurement); });
  return {T_world_robot * p.position, sandwiched(T_world_robot.linear(), p.covariance)};
}

LandmarkGaussian update_landmark(const LandmarkGaussian& landmark, const Innovation& innovation,
                                 const Measurement& measurement, const Eigen::Isometry3d& T_world_robot,
                                 double added_variance) {
  return with_model(measurement, [&](auto model) {
    LandmarkGaussian result = update_as(model, landmark, innovation, measurement, T_world_robot.linear());
    const bool planar = measurement.kind == MeasurementKind::planar ||
                        measurement.kind == MeasurementKind::range_bearing;  // the height is no estimate
    result.covariance.diagonal().head(planar ? 2 : 3).array() += added_variance;
    return result;
  });
}

}  // namespace lcmslam
