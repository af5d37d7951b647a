#include <lcmslam/fastslam/association/usable_features.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

namespace lcmslam {
namespace {

// A 3-D point of the camera, in the robot frame.
std::optional<FeaturePoint> camera_point(const Feature& feature, const FeatureFrame& frame,
                                         const FastSlamSettings& s) {
  if (!feature.point.allFinite() || !(feature.point.z() > 0) || !(feature.depth_sigma > 0))
    return std::nullopt;
  const Eigen::Vector3d point = feature.point.cast<double>();
  FeaturePoint result;
  result.range = point.norm();
  if (result.range < s.minimum_range || result.range > s.maximum_range) return std::nullopt;
  const Eigen::Matrix3d C =
      s.measurement_sigma > 0
          ? Eigen::Matrix3d(std::pow(s.measurement_sigma, 2) * Eigen::Matrix3d::Identity())
          : point_covariance(feature, frame);
  if (!C.allFinite() || C.diagonal().minCoeff() <= 0) return std::nullopt;
  const Eigen::Matrix3d R = frame.T_robot_camera.linear();
  const Eigen::Matrix3d covariance = s.measurement_inflation * (R * C * R.transpose());
  result.measurement = {frame.T_robot_camera * point, 0.5 * (covariance + covariance.transpose())};
  return result;
}

// A pixel without depth. An identity would need a landmark of the plane.
std::optional<FeaturePoint> camera_bearing(const Feature& feature, const FeatureFrame& frame,
                                           const FastSlamSettings& s) {
  if (!s.use_bearings || feature.landmark_id >= 0) return std::nullopt;
  FeaturePoint result;
  Measurement& m = result.measurement;
  m.kind = MeasurementKind::bearing;
  m.value << (feature.x - frame.cx) / frame.fx, (feature.y - frame.cy) / frame.fy, 0;
  const double sigma = pixel_sigma(feature, frame);
  const double u = sigma / frame.fx, v = sigma / frame.fy;
  m.covariance.diagonal() << s.measurement_inflation * u * u, s.measurement_inflation * v * v, 1;
  m.T_robot_camera = &frame.T_robot_camera;
  return result;
}

// A measurement in the robot's plane (see feature.hpp for its noise). It has no descriptor: without an
// identity nothing says which landmark it shows.
std::optional<FeaturePoint> planar_measurement(const Feature& feature, const FeatureFrame& frame,
                                               const FastSlamSettings& s) {
  const bool sound = feature.depth_sigma > 0 && feature.depth_sigma < 1e3F && feature.point.norm() < 1e4F;
  if (feature.landmark_id < 0 || !sound) return std::nullopt;
  FeaturePoint result;
  Measurement& m = result.measurement;
  m.kind = feature.kind;
  m.value << feature.point.cast<double>().head<2>(), 0;
  const double along = feature.depth_sigma;
  const bool polar = feature.kind == MeasurementKind::range_bearing;
  const double across = polar ? frame.pixel_sigma / frame.fx : along;
  result.range = polar ? m.value.x() : m.value.norm();
  if (!(result.range > 0)) return std::nullopt;
  m.covariance.diagonal() << s.measurement_inflation * along * along,
      s.measurement_inflation * across * across, 1;
  return result;
}

}  // namespace

std::vector<FeaturePoint> usable_features(const FeatureFrame& frame, const FastSlamSettings& s) {
  std::vector<FeaturePoint> points;
  if (!(frame.fx > 0 && frame.fy > 0 && frame.pixel_sigma > 0) || !frame.T_robot_camera.matrix().allFinite())
    return points;  // without a calibration nothing is usable
  for (std::size_t i = 0; i < frame.features.size(); ++i) {
    const Feature& feature = frame.features[i];
    if (!std::isfinite(feature.x) || !std::isfinite(feature.y) || !std::isfinite(feature.response)) continue;
    auto usable = feature.kind == MeasurementKind::point     ? camera_point(feature, frame, s)
                  : feature.kind == MeasurementKind::bearing ? camera_bearing(feature, frame, s)
                                                             : planar_measurement(feature, frame, s);
    if (!usable) continue;
    usable->feature = static_cast<int>(i);
    usable->landmark_id = feature.landmark_id;
    points.push_back(*usable);
  }
  std::sort(points.begin(), points.end(), [&](const FeaturePoint& a, const FeaturePoint& b) {
    const Feature& p = frame.features[static_cast<std::size_t>(a.feature)];
    const Feature& q = frame.features[static_cast<std::size_t>(b.feature)];
    const Eigen::Vector3d &u = a.measurement.value, &v = b.measurement.value;
    return std::tie(q.response, p.y, p.x, p.landmark_id, u.x(), u.y(), a.feature) <
           std::tie(p.response, q.y, q.x, q.landmark_id, v.x(), v.y(), b.feature);
  });
  return points;
}

namespace {

// How far away it is nobody knows: only what turning does to it, (x, y, 1) of the camera.
Eigen::Vector3d bearing_velocity(const Measurement& bearing, const Vector6d& twist) {
  const Eigen::Vector3d ray(bearing.value.x(), bearing.value.y(), 1);
  const Eigen::Vector3d v = ray.cross(bearing.T_robot_camera->linear().transpose() * twist.tail<3>());
  return v - v.z() * ray;
}

}  // namespace

void widen_for_motion(const Vector6d& twist, double timing_sigma, std::vector<FeaturePoint>& points) {
  if (!(timing_sigma > 0) || !twist.allFinite()) return;
  for (FeaturePoint& point : points) {
    Measurement& m = point.measurement;
    if (m.kind != MeasurementKind::point && m.kind != MeasurementKind::bearing) continue;
    const Eigen::Vector3d shift =
        timing_sigma * (point.is_bearing() ? bearing_velocity(m, twist) : point_velocity(m.value, twist));
    m.covariance += shift * shift.transpose();
  }
}

}  // namespace lcmslam
