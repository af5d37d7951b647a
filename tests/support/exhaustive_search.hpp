#pragma once
// Random points and what a search among them must find.

#include <Eigen/Core>
#include <vector>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {

/// In the cube of +-side.
inline Eigen::Vector3f random_point_within(Random& random, double side) {
  const double x = random.uniform(-side, side);
  const double y = random.uniform(-side, side);
  const double z = random.uniform(-side, side);
  return Eigen::Vector3d(x, y, z).cast<float>();
}

/// Index of the nearest point, ties to the lower one; -1 when it is farther than max_distance.
inline int nearest_by_exhaustion(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& query,
                                 float max_distance) {
  int best = -1;
  float least = max_distance * max_distance;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float d = (points[i] - query).squaredNorm();
    if (d < least || (d == least && best < 0)) {
      least = d;
      best = static_cast<int>(i);
    }
  }
  return best;
}

}  // namespace lcmslam
