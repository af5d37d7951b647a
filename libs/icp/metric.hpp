#pragma once
// What is minimised over the pairs, linearised about T_target_source with the right perturbation
// T exp(xi): residual(xi) = residual + jacobian * xi. Rows of a point-to-plane pair: one; of a
// point-to-point pair: three.

#include <memory>

#include "icp/pair.hpp"
#include "icp/registration_settings.hpp"

namespace lcmslam {

/// Sum over pairs of w J^T J, -w J^T r, w r^2, and of w times the squared norm of one row's normal.
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double squared_error = 0;  ///< weighted
  double weight = 0;         ///< sum of weights times residual rows
};

class Metric {
 public:
  virtual ~Metric() = default;
  /// Squared residual in m^2.
  virtual double squared_error(const Pair& pair) const = 0;
  /// Adds the pair with its weight; R = rotation of T_target_source.
  virtual void add(const Pair& pair, const Eigen::Matrix3d& R, NormalEquations& equations) const = 0;
};

/// r = n^T (T p - q) (Chen and Medioni 1991).
class PointToPlane : public Metric {
 public:
  double squared_error(const Pair& pair) const override;
  void add(const Pair& pair, const Eigen::Matrix3d& R, NormalEquations& equations) const override;
};

/// r = T p - q (Besl and McKay 1992; thesis eq. 3.1).
class PointToPoint : public Metric {
 public:
  double squared_error(const Pair& pair) const override;
  void add(const Pair& pair, const Eigen::Matrix3d& R, NormalEquations& equations) const override;
};

std::unique_ptr<Metric> make_metric(MetricKind kind);

}  // namespace lcmslam
