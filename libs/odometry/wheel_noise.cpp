#include <lcmslam/odometry/wheel_noise.hpp>

#include <cmath>

namespace lcmslam {
namespace {

double square(double value) {
  return value * value;
}

}  // namespace

Matrix6d increment_covariance(const WheelNoise& noise, const PlanarIncrement& of_body) {
  // Tyres hold their axle: there errors are independent, and a wrong heading swings the rest about it.
  const Eigen::Vector2d axle = of_body.held_at.value_or(Eigen::Vector2d::Zero());
  PlanarIncrement increment = of_body;
  increment.x -= of_body.heading * axle.y();
  increment.y += of_body.heading * axle.x();
  const double way = increment.way_rolled;
  const double slips = way / noise.slip_distance;
  const double rest_translation = square(noise.rest_translation) * increment.duration;
  const double rest_rotation = square(noise.rest_rotation) * increment.duration;

  const double translation = square(noise.translation_drift) * way + square(noise.slip_translation) * slips;
  const double rotation = square(noise.rotation_drift) * way + square(noise.slip_rotation) * slips;
  const double flatness = square(noise.flatness) * way;

  // The scale along the direction of motion: a way in both axes shares its length between them.
  const double length = std::hypot(increment.x, increment.y);
  const double along_x = length > 0 ? square(increment.x) / length : 0;
  const double along_y = length > 0 ? square(increment.y) / length : 0;

  Vector6d variance;
  variance[0] =
      square(noise.longitudinal_scale) * noise.scale_length * along_x + translation + rest_translation;
  variance[1] = increment.held_at ? square(noise.side_drift) * way + rest_translation
                                  : square(noise.lateral_scale) * noise.scale_length * along_y + translation +
                                        rest_translation;
  variance[2] = flatness + rest_translation;
  variance[3] = variance[4] = flatness + rest_rotation;
  variance[5] = square(noise.rotation_scale) * noise.scale_angle * std::abs(increment.heading) + rotation +
                rest_rotation;
  const Matrix6d A = adjoint(planar_pose(axle.x(), axle.y(), 0));
  return A * variance.asDiagonal() * A.transpose();
}

}  // namespace lcmslam
