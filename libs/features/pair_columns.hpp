#pragma once
// Matched 3-D points as RANSAC and least squares go through them: a column for each number, so that a motion
// is held against several pairs at once.

#include <Eigen/Dense>
#include <cstddef>
#include <vector>

#include <lcmslam/features/rigid_ransac.hpp>

namespace lcmslam {

/// What a motion leaves of some pairs, in frame b: e = T_a_b^-1 p_a - p_b and the inverse of its covariance
/// R' S_a R + S_b.
struct PairResiduals {
  static constexpr int most = 32;
  double error[3][most];
  double information[6][most];  ///< xx, xy, xz, yy, yz, zz
  double distance2[most];       ///< squared Mahalanobis distance
};

class PairColumns {
 public:
  explicit PairColumns(const std::vector<PointPair>& pairs);
  PairColumns(const std::vector<PointPair>& pairs, const std::vector<int>& indices);

  int size() const { return static_cast<int>(size_); }
  Eigen::Vector3d point_b(int i) const;

  /// Of pairs first, first + 1, ...; returns how many: PairResiduals::most, or those that are left.
  int measure(const Eigen::Isometry3d& T_a_b, int first, PairResiduals& residuals) const;

 private:
  void put(std::size_t i, const PointPair& pair);
  const double* column(std::size_t number) const { return numbers_.data() + number * size_; }

  std::size_t size_;
  std::vector<double> numbers_;  // columns: p_a, p_b, the upper triangles of S_a and S_b
};

}  // namespace lcmslam
