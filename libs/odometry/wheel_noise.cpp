#include <lcmslam/odometry/wheel_noise.hpp>

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace lcmslam {
namespace {

double square(double value) {
  return value * value;
}

}  // namespace

void WheelNoise::check() const {
  const std::pair<const char*, double> not_negative[] = {{"longitudinal_scale", longitudinal_scale},
                                                         {"lateral_scale", lateral_scale},
                                                         {"rotation_scale", rotation_scale},
                                                         {"scale_length", scale_length},
                                                         {"scale_angle", scale_angle},
                                                         {"translation_drift", translation_drift},
                                                         {"rotation_drift", rotation_drift},
                                                         {"slip_translation", slip_translation},
                                                         {"slip_rotation", slip_rotation}};
  const std::pair<const char*, double> positive[] = {{"slip_distance", slip_distance},
                                                     {"flatness", flatness},
                                                     {"rest_translation", rest_translation},
                                                     {"rest_rotation", rest_rotation}};
  const auto fail = [](const char* name, double value, const char* right) {
    throw std::invalid_argument("wheel noise: " + std::string(name) + " is " + std::to_string(value) +
                                "; expected a number " + right);
  };
  for (const auto& [name, value] : not_negative) {
    if (!(std::isfinite(value) && value >= 0)) fail(name, value, "of at least 0");
  }
  for (const auto& [name, value] : positive) {
    if (!(std::isfinite(value) && value > 0)) fail(name, value, "above 0");
  }
}

Matrix6d increment_covariance(const WheelNoise& noise, const PlanarIncrement& increment) {
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
  variance[1] = square(noise.lateral_scale) * noise.scale_length * along_y + translation + rest_translation;
  variance[2] = flatness + rest_translation;
  variance[3] = variance[4] = flatness + rest_rotation;
  variance[5] = square(noise.rotation_scale) * noise.scale_angle * std::abs(increment.heading) + rotation +
                rest_rotation;
  return variance.asDiagonal();
}

}  // namespace lcmslam
