#pragma once
// A feature that has a place in the world: what a mapper publishes, a map keeps and a picture shows. It
// stands here because both the filter and the map store see this room, and neither sees the other.

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include <lcmslam/features/feature.hpp>

namespace lcmslam {

struct Landmark {
  std::int64_t id = -1;                                      ///< never used twice
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();            ///< m, world
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< m^2, world axes
  int observations = 0;
  double log_odds = 0;                   ///< of existing
  std::array<std::uint8_t, 3> colour{};  ///< R, G, B
  std::int8_t laplacian = 0;             ///< see Feature
  Descriptor descriptor{};
};

}  // namespace lcmslam
