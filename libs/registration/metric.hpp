#pragma once
// What is minimised over the pairs, linearised about T_target_source with the right perturbation
// T exp(xi): residual(xi) = residual + jacobian * xi. Rows of a point-to-plane pair: one; of the others:
// three; the colour term adds one.

#include <memory>

#include <lcmslam/registration/pair.hpp>
#include <lcmslam/registration/registration_settings.hpp>

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

/// Generalised ICP (Segal, Haehnel and Thrun 2009): squared error r^T M r with M = 2 e (C_q + R C_p R^T)^-1,
/// where a point's C spreads by 1 in its surface and by e = 1e-3 along its normal. The factor 2 e makes an
/// error along two equal normals count as it does for point-to-plane. M is held fixed in the linearisation.
class PlaneToPlane : public Metric {
 public:
  double squared_error(const Pair& pair) const override;
  void add(const Pair& pair, const Eigen::Matrix3d& R, NormalEquations& equations) const override;
};

/// Another metric, and scale * (I_q + g^T (T p - q) - I_p): the target's intensity, continued linearly in its
/// tangent plane, against the source's (Park, Zhou and Koltun 2017). Pairs without intensities or gradient
/// have the other metric's error alone.
class WithColour : public Metric {
 public:
  /// `scale`: m that count as much as a difference from black to white.
  WithColour(std::unique_ptr<Metric> geometry, double scale)
      : geometry_(std::move(geometry)), scale_(scale) {}
  double squared_error(const Pair& pair) const override;
  void add(const Pair& pair, const Eigen::Matrix3d& R, NormalEquations& equations) const override;

 private:
  std::unique_ptr<Metric> geometry_;
  double scale_;
};

/// That of the settings, with a colour term where they ask for it.
std::unique_ptr<Metric> make_metric(const RegistrationSettings& settings);

}  // namespace lcmslam
