#include <lcmslam/fastslam/error_ensemble.hpp>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <lcmslam/fastslam/pose_space.hpp>

namespace lcmslam {
namespace {

constexpr std::uint64_t ensemble_stream = 0x656e73656d626c65;
using Jacobian = Eigen::Matrix<double, 3, 6>;

// The filter's equations for one measurement, linear about the landmark as it is now.
struct Equations {
  Jacobian J;         // of the landmark in the robot frame by the pose
  Eigen::Matrix3d G;  // of the measurement by the landmark in the robot frame
  Eigen::Matrix3d S_inverse;
  Eigen::Matrix3d gain;
};

Eigen::Matrix3d jacobian_of(const Measurement& measurement, const Eigen::Vector3d& p) {
  return with_model(measurement, [&](auto model) -> Eigen::Matrix3d { return model.jacobian(p); });
}

Jacobian pose_jacobian(const Eigen::Vector3d& p, bool planar) {
  Jacobian J = PoseSpace<6>::residual_jacobian(p);
  if (planar) J.middleCols<3>(2).setZero();
  return J;
}

// From the landmark's covariance after its update: K = P+ G^T R^-1 and S^-1 = R^-1 - R^-1 G P+ G^T R^-1. A
// bearing may move a landmark that is near the camera far along its ray. About where it is now these are not
// the update's equations any more, and S^-1 may be negative: it tells nothing then.
Equations equations(const EnsembleObservation& seen, const Eigen::Isometry3d& T_world_robot, bool planar,
                    double added_variance) {
  const Eigen::Matrix3d& R = T_world_robot.linear();
  const Eigen::Vector3d p = predict_measurement(seen.landmark.mean, T_world_robot);
  const Eigen::Matrix3d P =
      R.transpose() * seen.landmark.covariance * R - added_variance * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d noise = seen.measurement.covariance.inverse();
  Equations e;
  e.J = pose_jacobian(p, planar);
  e.G = jacobian_of(seen.measurement, p);
  e.gain = P * e.G.transpose() * noise;
  e.S_inverse = noise - noise * e.G * e.gain;
  constexpr double rounding = 1e-3;  // of R^-1: nothing is left of it where little was known before
  if ((e.S_inverse + rounding * noise).llt().info() != Eigen::Success) {
    e.S_inverse.setZero();
    e.gain.setZero();
  }
  return e;
}

}  // namespace

ErrorEnsemble::ErrorEnsemble(const FastSlamSettings& settings)
    : planar_(settings.planar),
      draw_share_(settings.planar ? settings.draw_share : settings.free_draw_share),
      free_draw_share_(settings.free_draw_share),
      landmark_variance_(settings.minimum_landmark_sigma * settings.minimum_landmark_sigma),
      stream_(settings.seed, ensemble_stream) {}

void ErrorEnsemble::leave_plane() {
  planar_ = false;
  draw_share_ = free_draw_share_;
}

// Only what is free.
Matrix6d ErrorEnsemble::restricted(const Matrix6d& covariance) const {
  const Matrix6d symmetric = 0.5 * (covariance + covariance.transpose());
  return planar_ ? PoseSpace<3>::expand(PoseSpace<3>::reduce(symmetric)) : symmetric;
}

ErrorEnsemble::Twists ErrorEnsemble::drawn(const Matrix6d& covariance) {
  Matrix6d P = restricted(covariance);
  P.diagonal().array() += 1e-14;
  Matrix6d root = P.llt().matrixL();
  if (planar_) root.middleRows<3>(2).setZero();
  Twists signs;
  const std::uint64_t low[3] = {stream_.bits(), stream_.bits(), stream_.bits()};
  const std::uint64_t high[3] = {stream_.bits(), stream_.bits(), stream_.bits()};
  signs << random_signs(low), random_signs(high);
  return root.cast<float>().lazyProduct(signs);
}

void ErrorEnsemble::move(const Motion& step) {
  const Matrix6d A = adjoint(step.T_from_to.inverse());
  robot_ = (A.cast<float>().lazyProduct(robot_) + drawn(step.covariance)).eval();
}

void ErrorEnsemble::observe(const std::vector<EnsembleObservation>& accepted,
                            const Eigen::Isometry3d& T_world_robot, const std::optional<Matrix6d>& prior) {
  if (accepted.empty()) return;
  const Eigen::Matrix3f R = T_world_robot.linear().cast<float>();
  std::vector<Equations> equations_of;
  Matrix6d information = Matrix6d::Zero();
  for (int i = 0; i < 6; ++i) information(i, i) = planar_ && i > 1 && i < 5 ? 1 : 1e-6;
  Twists pull = Twists::Zero();
  if (prior) {
    Matrix6d Q = restricted(*prior);
    for (int i = 0; i < 6; ++i)
      if (planar_ && i > 1 && i < 5) Q(i, i) = 1;
    const Matrix6d weight = Q.llt().solve(Matrix6d::Identity());
    information += weight;
    pull = weight.cast<float>().lazyProduct(robot_);
  }
  for (const EnsembleObservation& seen : accepted) {
    const Equations& e =
        equations_of.emplace_back(equations(seen, T_world_robot, planar_, landmark_variance_));
    const Eigen::Matrix<double, 6, 3> weighted = e.J.transpose() * e.G.transpose() * e.S_inverse;
    information += weighted * e.G * e.J;
    const EnsembleVectors& f = landmarks_[static_cast<std::size_t>(seen.slot)];
    const Eigen::Matrix3f to_measurement = e.G.cast<float>() * R.transpose();
    const EnsembleVectors told = to_measurement.lazyProduct(f) + seen.error;
    pull += weighted.cast<float>().lazyProduct(told);
  }
  const Matrix6d covariance = information.llt().solve(Matrix6d::Identity());
  robot_ = covariance.cast<float>().lazyProduct(pull) + drawn(draw_share_ * covariance);
  for (std::size_t i = 0; i < accepted.size(); ++i) {
    const Equations& e = equations_of[i];
    EnsembleVectors& f = landmarks_[static_cast<std::size_t>(accepted[i].slot)];
    const EnsembleVectors in_robot = R.transpose().lazyProduct(f) - e.J.cast<float>().lazyProduct(robot_);
    const EnsembleVectors innovation = e.G.cast<float>().lazyProduct(in_robot) + accepted[i].error;
    f -= (R * e.gain.cast<float>()).lazyProduct(innovation);
  }
}

void ErrorEnsemble::create(const std::vector<EnsembleObservation>& created,
                           const Eigen::Isometry3d& T_world_robot) {
  const Eigen::Matrix3f R = T_world_robot.linear().cast<float>();
  for (const EnsembleObservation& made : created) {
    const auto slot = static_cast<std::size_t>(made.slot);
    if (slot >= landmarks_.size()) landmarks_.resize(slot + 1, EnsembleVectors::Zero());
    const Eigen::Vector3d p = predict_measurement(made.landmark.mean, T_world_robot);
    Eigen::Matrix3d inverse = Eigen::Matrix3d::Identity();  // of the measurement's Jacobian
    if (made.measurement.kind != MeasurementKind::point) {
      inverse.setZero();
      inverse.topLeftCorner<2, 2>() = jacobian_of(made.measurement, p).topLeftCorner<2, 2>().inverse();
    }
    const EnsembleVectors in_robot = pose_jacobian(p, planar_).cast<float>().lazyProduct(robot_) -
                                     inverse.cast<float>().lazyProduct(made.error);
    landmarks_[slot] = R.lazyProduct(in_robot);
  }
}

// Errors about the estimate itself. A covariance from n members makes e^T P^-1 e larger by n / (n - d - 1) in
// the mean (of an inverse Wishart distribution): that much wider is honest.
Matrix6d ErrorEnsemble::pose() const {
  const int dimension = planar_ ? 3 : 6;
  const Eigen::Matrix<double, 6, ensemble_size> errors = robot_.cast<double>();
  const Matrix6d P = errors * errors.transpose() / (ensemble_size - dimension - 1);
  return 0.5 * (P + P.transpose());
}

Eigen::Matrix3d ErrorEnsemble::landmark(int slot) const {
  const Eigen::Matrix<double, 3, ensemble_size> errors =
      landmarks_[static_cast<std::size_t>(slot)].cast<double>();
  const Eigen::Matrix3d P = errors * errors.transpose() / (ensemble_size - 4);
  return 0.5 * (P + P.transpose());
}

}  // namespace lcmslam
