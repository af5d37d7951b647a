#pragma once
// What a particle remembers of its landmarks. A hundred particles times ten thousand landmarks: the fewer
// bytes, the fewer cache misses, and these are what a step of the filter costs.

#include <algorithm>
#include <array>

#include <lcmslam/fastslam/landmarks/landmark_filter.hpp>
#include <lcmslam/fastslam/landmarks/persistent_array.hpp>

namespace lcmslam {

/// A landmark's Gaussian in 48 bytes instead of 96: the mean exact (4 km away a float is off by 0.2 mm), the
/// covariance as L D L^T in floats, L unit lower triangular. So it is symmetric and positive
/// definite whatever is rounded (Bierman 1977, "Factorization methods for discrete sequential estimation"),
/// and each factor is right to 6e-8 of itself.
class CompactLandmark {
 public:
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< m, world
  using Factors = std::array<float, 6>;            // D, L10, L20, L21
  /// What is left of a variance after cancellation is not known better than to this part of it.
  static constexpr double least_part = 1e-12;

  CompactLandmark() = default;
  CompactLandmark(const Eigen::Vector3d& mean_, const Factors& factors) : mean(mean_), factors_(factors) {}
  CompactLandmark(const LandmarkGaussian& g)
      : CompactLandmark(g.mean, g.covariance) {}  // NOLINT: same meaning
  /// `P`: m^2, world, symmetric and positive definite.
  CompactLandmark(const Eigen::Vector3d& mean_, const Eigen::Matrix3d& P) : mean(mean_) {
    constexpr double least = least_part;
    const double d0 = P(0, 0), l10 = P(1, 0) / d0, l20 = P(2, 0) / d0;
    const double d1 = std::max(P(1, 1) - l10 * P(1, 0), least * P(1, 1));
    const double m21 = P(2, 1) - l20 * P(1, 0), l21 = m21 / d1;
    const double d2 = std::max(P(2, 2) - l20 * P(2, 0) - l21 * m21, least * P(2, 2));
    const double factors[6] = {d0, d1, d2, l10, l20, l21};
    for (std::size_t i = 0; i < 6; ++i) factors_[i] = static_cast<float>(factors[i]);
  }

  /// m^2, world.
  Eigen::Matrix3d covariance() const {
    const double d0 = factors_[0], d1 = factors_[1], d2 = factors_[2];
    const double l10 = factors_[3], l20 = factors_[4], l21 = factors_[5];
    const double p10 = l10 * d0, p20 = l20 * d0, m21 = l21 * d1, p21 = l20 * p10 + m21;
    Eigen::Matrix3d P;
    P << d0, p10, p20, p10, l10 * p10 + d1, p21, p20, p21, l20 * p20 + l21 * m21 + d2;
    return P;
  }
  /// Its trace.
  double variance() const {
    const double d0 = factors_[0], d1 = factors_[1], d2 = factors_[2];
    const double l10 = factors_[3], l20 = factors_[4], l21 = factors_[5];
    return d0 * (1 + l10 * l10 + l20 * l20) + d1 * (1 + l21 * l21) + d2;
  }

  /// To the last bit.
  bool operator==(const CompactLandmark& o) const { return mean == o.mean && factors_ == o.factors_; }

  const Factors& factors() const { return factors_; }

  operator LandmarkGaussian() const { return {mean, covariance()}; }  // NOLINT: same meaning

 private:
  Factors factors_ = {1, 1, 1, 0, 0, 0};
};

/// A particle's landmarks by slot (see LandmarkIndex).
using ParticleMap = PersistentArray<CompactLandmark>;

}  // namespace lcmslam
