#include <lcmslam/fastslam/sensor_error.hpp>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

constexpr std::uint64_t error_stream = 0x73656e736f72, bend_stream = 0x62656e64;
constexpr double range_step = 0.05, farthest_wave = 50;   // m, of the table of waves
constexpr double shortest_wave = 1.5, longest_wave = 12;  // m, of a depth camera's systematic error

std::uint64_t mixed(std::uint64_t x) {  // splitmix64 (Steele, Lea and Flood 2014)
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

}  // namespace

EnsembleVectors random_signs(const std::uint64_t (&words)[3]) {
  EnsembleVectors signs;
  for (int row = 0; row < 3; ++row)
    for (int k = 0; k < ensemble_size; ++k) signs(row, k) = (words[row] >> k & 1U) != 0 ? 1.F : -1.F;
  return signs;
}

SensorError::SensorError(const FastSlamSettings& settings)
    : settings_(settings), stream_(settings.seed, error_stream), seed_(mixed(settings.seed)) {
  EnsembleRow frequency, phase;
  for (int k = 0; k < ensemble_size; ++k) {
    const double wave = shortest_wave * std::pow(longest_wave / shortest_wave, stream_.uniform());
    frequency(k) = static_cast<float>(2 * M_PI / wave);
    phase(k) = static_cast<float>(stream_.uniform(0, 2 * M_PI));
    focal_x_(k) = static_cast<float>(stream_.normal(0, settings.focal_sigma));
    focal_y_(k) = static_cast<float>(stream_.normal(0, settings.focal_sigma));
    stamp_(k) = static_cast<float>(stream_.normal(0, settings.stamp_sigma));
    shutter_(k) = static_cast<float>(stream_.normal(0, settings.shutter_sigma));
    slide_(k) = static_cast<float>(stream_.normal(0, settings.slide_sigma));
  }
  Random bends(settings.seed, bend_stream);  // apart, so that what is drawn otherwise does not depend on it
  for (int k = 0; k < ensemble_size; ++k) bend_(k) = static_cast<float>(bends.normal(0, settings.bend_sigma));
  for (double range = 0; range <= std::min(settings.maximum_range, farthest_wave) + range_step;
       range += range_step)
    depth_waves_.emplace_back(std::sqrt(2.F) * (static_cast<float>(range) * frequency + phase).array().cos());
}

EnsembleRow SensorError::depth_wave(double range) const {
  const auto at = static_cast<std::size_t>(std::lround(std::min(range, farthest_wave) / range_step));
  return depth_waves_[std::min(at, depth_waves_.size() - 1)];
}

// The same as long as the landmark is seen from about the same direction and distance.
EnsembleVectors SensorError::of_view(const Eigen::Vector3d& ray, std::int64_t landmark) const {
  const double range = ray.norm(), step = settings_.view_step;
  std::uint64_t key = mixed(seed_ ^ static_cast<std::uint64_t>(landmark));
  for (const double part : {ray.x() / range, ray.y() / range, ray.z() / range, std::log(range)})
    key = mixed(key ^ static_cast<std::uint64_t>(std::llround(part / step)));
  return random_signs({mixed(key ^ 1U), mixed(key ^ 2U), mixed(key ^ 3U)});
}

// In the robot's frame.
Eigen::Vector3d SensorError::way_since_first_seen(Landmark landmark, const Eigen::Isometry3d& T_world_robot) {
  const auto slot = static_cast<std::size_t>(landmark.slot);
  if (first_views_.size() <= slot) first_views_.resize(slot + 1);
  FirstView& first = first_views_[slot];
  if (first.landmark != landmark.id) first = {landmark.id, T_world_robot.translation()};
  return T_world_robot.linear().transpose() * (T_world_robot.translation() - first.from);
}

EnsembleVectors SensorError::draw(const FeaturePoint& point, const FeatureFrame& frame, Landmark landmark,
                                  const Eigen::Isometry3d& T_world_robot, const Vector6d& twist) {
  return point.measurement.kind == MeasurementKind::point
             ? of_point(point, frame, landmark, T_world_robot, twist)
             : of_plane(point.measurement);
}

EnsembleVectors SensorError::of_plane(const Measurement& measurement) {
  const Eigen::Matrix3d covariance = measurement.covariance / settings_.measurement_inflation;
  const Eigen::Matrix3f root = Eigen::Matrix3d(covariance.llt().matrixL()).cast<float>();
  EnsembleVectors error = root.lazyProduct(random_signs({stream_.bits(), stream_.bits(), 0}));
  error.row(2).setZero();
  return error;
}

EnsembleVectors SensorError::of_point(const FeaturePoint& point, const FeatureFrame& frame, Landmark landmark,
                                      const Eigen::Isometry3d& T_world_robot, const Vector6d& twist) {
  const Feature& feature = frame.features[static_cast<std::size_t>(point.feature)];
  const Eigen::Vector3d& p = point.measurement.value;
  const Eigen::Vector3d ray = p - frame.T_robot_camera.translation();
  const Eigen::Vector3d systematic = settings_.systematic_depth * feature.depth_sigma * ray.normalized();

  // What is this feature's, lasting or new.
  const Eigen::Matrix3d own =
      point.measurement.covariance / settings_.measurement_inflation - systematic * systematic.transpose();
  const auto lasting = static_cast<float>(std::sqrt(settings_.view_share));
  const auto fresh = static_cast<float>(std::sqrt(1 - settings_.view_share));
  const EnsembleVectors random = lasting * of_view(T_world_robot.linear() * ray, landmark.id) +
                                 fresh * random_signs({stream_.bits(), stream_.bits(), stream_.bits()});
  EnsembleVectors error = Eigen::Matrix3d(own.llt().matrixL()).cast<float>().lazyProduct(random);

  // What is the camera's: depth, focal lengths, time.
  const Eigen::Matrix3d& R = frame.T_robot_camera.linear();
  const Eigen::Vector3d by_x = R.col(0) * R.col(0).dot(ray), by_y = R.col(1) * R.col(1).dot(ray);
  const Eigen::Vector3d velocity = point_velocity(p, twist);
  const auto row =
      static_cast<float>(frame.height > 0 ? feature.y / static_cast<float>(frame.height) - 0.5F : 0);
  error += systematic.cast<float>().lazyProduct(depth_wave(ray.norm()));
  error += by_x.cast<float>().lazyProduct(focal_x_) + by_y.cast<float>().lazyProduct(focal_y_);
  const Eigen::Vector3d way = way_since_first_seen(landmark, T_world_robot);
  const Eigen::Vector3d by_turning = Eigen::Vector3d::UnitZ().cross(p);  // of the robot about the vertical
  error += way.cast<float>().lazyProduct(slide_);
  error += (way.norm() * by_turning).cast<float>().lazyProduct(bend_);
  error += velocity.cast<float>().lazyProduct(EnsembleRow(stamp_ + row * shutter_));
  return error;
}

}  // namespace lcmslam
