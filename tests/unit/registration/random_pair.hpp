#pragma once
#include <lcmslam/registration/pair.hpp>
#include "tests/unit/geometry/random_poses.hpp"

namespace lcmslam {

/// A pair moved by T, with all that metrics and weights ask of it.
inline Pair random_pair(Random& random, const Eigen::Isometry3d& T) {
  Pair p;
  p.source = random_vector(random, 1);
  p.moved = T * p.source;
  p.target = p.moved + random_vector(random, 0.1);
  p.target_normal = random_vector(random, 1).normalized();
  p.moved_normal = random_vector(random, 1).normalized();
  p.weight = random.uniform(0.5, 2);
  p.source_intensity = random.uniform();
  p.target_intensity = random.uniform();
  p.target_gradient = random_vector(random, 1);
  return p;
}

}  // namespace lcmslam
