#pragma once
// Rigid motion between two sets of matched 3-D points, of which some matches are wrong: RANSAC
// (Fischler & Bolles 1981) with the sensor's noise deciding who is an inlier, local optimisation of each
// best hypothesis (LO-RANSAC: Chum, Matas & Kittler 2003), then least squares.

#include <string>
#include <vector>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/features/matching.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct RigidRansacSettings {
  int min_inliers = 12;
  int max_iterations = 2000;
  double confidence = 0.999;
  double chi_square = 11.345;
  int max_refinements = 10;

  void describe(SettingsVisitor& s) {
    s.number("min_inliers", min_inliers, "", {3, 1e6}, "fewer are a failure");
    s.number("max_iterations", max_iterations, "", {1, 1e9},
             "upper limit of hypotheses; fewer when many matches agree");
    s.number("confidence", confidence, "", {0.01, 0.999999}, "of having drawn one sample without outliers");
    s.number("chi_square", chi_square, "", {0.01, 1e6},
             "inliers have a squared Mahalanobis distance below this (3 DoF, 99 %)");
    s.number("max_refinements", max_refinements, "", {1, 1000}, "rounds of least squares and new inliers");
  }
};

/// One match: the same point measured in frames a and b, with 3x3 covariances, metres.
struct PointPair {
  Eigen::Vector3d point_a, point_b;
  Eigen::Matrix3d covariance_a, covariance_b;
};

struct RigidRansacResult {
  bool success = false;
  std::string reason;  ///< why not, empty on success
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< of T_a_b, body frame (right perturbation)
  std::vector<int> inliers;                ///< indices into the input, ascending
  int iterations = 0;                      ///< hypotheses tried
};

/// T_a_b that minimises the sum over inliers of e' (S_a + R S_b R')^-1 e, e = p_a - T_a_b p_b. The
/// covariance is the inverse of the Gauss-Newton normal matrix. Draws from `random` alone: same seed,
/// same result. On failure T_a_b and inliers hold the best that was found.
/// Throws std::invalid_argument when a setting is out of its range; pairs that are not finite are never
/// inliers.
RigidRansacResult align_ransac(const std::vector<PointPair>& pairs, const RigidRansacSettings& settings,
                               Random& random);

/// The same for matched features; matches without a 3-D point on both sides cannot be inliers.
/// `inliers` indexes `matches`. Frame a and b are the two colour camera frames.
RigidRansacResult align_ransac(const FeatureFrame& a, const FeatureFrame& b,
                               const std::vector<Match>& matches, const RigidRansacSettings& settings,
                               Random& random);

/// Least-squares refinement alone, on the given pairs (indices), from a start near the solution. Returns
/// false when the pairs do not fix the motion. `covariance` as in the result above.
bool refine_rigid(const std::vector<PointPair>& pairs, const std::vector<int>& indices,
                  Eigen::Isometry3d& T_a_b, Matrix6d& covariance);

}  // namespace lcmslam
