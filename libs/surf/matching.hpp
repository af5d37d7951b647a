#pragma once
// Which feature of one image is which of another: mutual nearest neighbours of the byte descriptors.

#include <vector>

#include "surf/feature.hpp"

namespace lcmslam {

struct Match {
  int a = 0, b = 0;   ///< indices into the two sets
  int distance2 = 0;  ///< squared Euclidean distance of the bytes
};

struct MatchingSettings {
  /// Lowe's ratio: a match is kept when its distance (not squared) is below this times the distance to
  /// the second nearest of b. 1: only the mutual test.
  double ratio = 0.8;
  /// Blobs match only blobs of the same Laplacian sign (Bay et al. 2008, section 4.3).
  bool same_laplacian = true;
};

/// Matches ordered by a. a and b must be each other's nearest; of equally near ones the first counts.
/// The ratio is taken among those that the Laplacian admits; with just one candidate it holds.
std::vector<Match> match(const std::vector<Feature>& a, const std::vector<Feature>& b,
                         const MatchingSettings& settings = {});

/// The same without signs.
std::vector<Match> match(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
                         double ratio = 0.8);

/// Squared Euclidean distance of two byte descriptors.
int squared_distance(const Descriptor& a, const Descriptor& b);

}  // namespace lcmslam
