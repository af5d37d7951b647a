#include <lcmslam/dense_mapper/settled_way.hpp>

#include <Eigen/Dense>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {
namespace {

constexpr int in_plane[3] = {0, 1, 5};

Eigen::Vector3d in_plane_of(const Vector6d& v) {
  return {v[0], v[1], v[5]};
}

Eigen::Matrix3d in_plane_of(const Matrix6d& m) {
  Eigen::Matrix3d block;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) block(i, j) = m(in_plane[i], in_plane[j]);
  return block;
}

}  // namespace

std::optional<Eigen::Isometry3d> SettledWay::observe(const Motion& motion,
                                                     const Eigen::Isometry3d& T_expected,
                                                     const RegistrationResult& placed, bool anchored) {
  constexpr double most = 3;                  // standard deviations
  const double slip = anchored ? 0.3 : 0.03;  // m and rad, of wheels at once
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();

  // By wheels, and as seen from where the robot was led.
  const Eigen::Matrix3d A = in_plane_of(adjoint(motion.T_from_to.inverse()));
  away_ = A * away_ - in_plane_of(se3_log(T_expected.inverse() * placed.T_target_source));
  covariance_ = A * covariance_ * A.transpose() + in_plane_of(motion.covariance);

  // By settled surfaces, which know of a slip as of all else; that is no error of the wheels from then on.
  const Eigen::Matrix3d known = in_plane_of(placed.settled->information);
  const Eigen::Vector3d gradient = in_plane_of(placed.settled->gradient);
  const auto corrected = [&](const Eigen::Matrix3d& covariance) -> Eigen::Matrix3d {
    return (I + covariance * known).inverse() * covariance;
  };
  away_ += corrected(covariance_ + slip * slip * I) * (gradient - known * away_);
  covariance_ = corrected(covariance_);

  const Eigen::Matrix3d spread = covariance_ + slip * slip * I;
  if (!(away_.dot(spread.inverse() * away_) > most * most)) return std::nullopt;
  Vector6d away = Vector6d::Zero();
  for (int i = 0; i < 3; ++i) away[in_plane[i]] = away_[i];
  away_.setZero();
  return placed.T_target_source * se3_exp(away);
}

}  // namespace lcmslam
