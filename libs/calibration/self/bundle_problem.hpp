#pragma once
// The least squares of one round, in Ceres's words.

#include <ceres/problem.h>
#include <Eigen/Core>
#include <vector>

#include <lcmslam/calibration/self/bundle_adjustment.hpp>
#include <lcmslam/calibration/self/bundle_state.hpp>
#include <lcmslam/calibration/self/sighting_comparison.hpp>

namespace lcmslam {

/// What counts besides what is seen.
struct BundlePriors {
  HeadNumbers sigmas{}, values{};
  double aspect = 0, range_curve = 0;  ///< of CalibrationPriors

  BundlePriors(const CalibrationPriors& priors, const HeadModel& start)
      : sigmas(priors.sigmas(start.start)),
        values(HeadModel(start.start).values),
        aspect(priors.aspect),
        range_curve(priors.range_curve) {}
};

class BundleProblem {
 public:
  /// State, comparisons and priors must outlive it.
  BundleProblem(BundleState& state, const Comparisons& comparisons, const BundlePriors& priors,
                const BundleSettings& settings);

  /// Moves the state. Throws std::runtime_error where there is no solution.
  void solve();

  /// Of the head's parameters that are compared to something and not held.
  struct HeadCovariance {
    std::vector<std::size_t> parameters;  ///< of the rows
    Eigen::MatrixXd covariance;
  };
  HeadCovariance head_covariance();

 private:
  void add(const Comparison& c);
  residuals::Patch weighed(residuals::Patch patch) const;
  residuals::SurfaceOfColour surface_of_colour(const Comparison& c) const;
  residuals::SurfaceOfOwnCamera surface_of_own_camera(const Comparison& c) const;
  void add_priors();
  void add_keyframe(std::size_t k, bool is_world);
  void add_curve_priors();
  bool is_moved(double* block) const;
  std::vector<double*> used_landmarks() const;

  BundleState& state_;
  const Comparisons& comparisons_;
  const BundlePriors& priors_;
  const BundleSettings& settings_;
  ceres::Problem problem_;
};

}  // namespace lcmslam
