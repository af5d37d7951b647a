#include "fastslam/proposal.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <type_traits>

#include "fastslam/pose_space.hpp"
#include "fastslam/small_cholesky.hpp"
#include "fastslam/symmetric.hpp"

namespace lcmslam {
namespace {

template <int D>
typename PoseSpace<D>::Vector standard_normal(Random& random) {
  typename PoseSpace<D>::Vector n;
  for (int i = 0; i < D; ++i) n(i) = random.normal();
  return n;
}

template <int D>
typename PoseSpace<D>::Matrix lower_root(const typename PoseSpace<D>::Matrix& symmetric) {
  return symmetric.llt().matrixL();
}

// FastSLAM 1.0: draw from the prior, p(x) / q(x) = 1.
template <int D>
class MotionProposal final : public Proposal {
 public:
  explicit MotionProposal(const Matrix6d& Q) : root_(lower_root<D>(PoseSpace<D>::reduce(Q))) {}

  ProposedPose propose(const Eigen::Isometry3d& T_world_prior, const std::vector<ObservedLandmark>&,
                       Random& random) const override {
    const typename PoseSpace<D>::Vector xi = root_ * standard_normal<D>(random);
    return {T_world_prior * se3_exp(PoseSpace<D>::expand(xi)), 0};
  }

 private:
  typename PoseSpace<D>::Matrix root_;
};

// FastSLAM 2.0 with all observations of a step at once: Gauss-Newton on
//   xi^T Q^-1 xi + sum_i rho(r_i^T S_i^-1 r_i),   r_i = z_i - h_i(T exp(xi)),
// from the prior mean. S_i holds the landmark's uncertainty too (Montemerlo 2003, eq. 3.29-3.31, there
// for one observation). rho is Huber's, so that one wrong match pulls the pose by a bounded force.
template <int D>
class MeasurementProposal final : public Proposal {
 public:
  using Space = PoseSpace<D>;
  using Vector = typename Space::Vector;
  using Matrix = typename Space::Matrix;

  struct Posterior {
    Vector mean;            // xi
    SmallCholesky<D> root;  // of the information
  };

  MeasurementProposal(const FastSlamSettings& settings, const Matrix6d& Q)
      : iterations_(settings.proposal_iterations),
        huber_(settings.huber_width),
        prior_information_(Space::reduce(Q).llt().solve(Matrix::Identity())),
        prior_log_root_(SmallCholesky<D>(prior_information_).half_log_determinant()) {}

  Posterior posterior(const Eigen::Isometry3d& T_prior,
                      const std::vector<ObservedLandmark>& observations) const {
    // S_i is formed once, at the prior's orientation.
    weights_.resize(observations.size());
    for (std::size_t i = 0; i < observations.size(); ++i)
      weights_[i] = invert_symmetric(
                        innovation_covariance(observations[i].landmark, observations[i].measurement, T_prior))
                        .inverse;

    Posterior result{Vector::Zero(), SmallCholesky<D>(prior_information_)};
    for (int iteration = 0; iteration < iterations_; ++iteration) {
      const Eigen::Isometry3d T = iteration == 0 ? T_prior : T_prior * se3_exp(Space::expand(result.mean));
      Matrix information = prior_information_;
      Vector gradient = prior_information_ * result.mean;
      for (std::size_t i = 0; i < observations.size(); ++i)
        add(observations[i], weights_[i], T, information, gradient);
      result.root = SmallCholesky<D>(information);
      result.mean -= result.root.solve(gradient);
    }
    return result;
  }

  ProposedPose propose(const Eigen::Isometry3d& T_prior, const std::vector<ObservedLandmark>& observations,
                       Random& random) const override {
    const Posterior q = posterior(T_prior, observations);
    const Vector normal = standard_normal<D>(random);
    const Vector xi = q.mean + q.root.solve_upper(normal);
    const double log_prior = prior_log_root_ - 0.5 * xi.dot(prior_information_ * xi);
    const double log_proposal = q.root.half_log_determinant() - 0.5 * normal.squaredNorm();
    return {T_prior * se3_exp(Space::expand(xi)), log_prior - log_proposal};
  }

 private:
  void add(const ObservedLandmark& observed, const Eigen::Matrix3d& S_inverse, const Eigen::Isometry3d& T,
           Matrix& information, Vector& gradient) const {
    const Measurement& z = observed.measurement;
    const Eigen::Vector3d p = predict_measurement(observed.landmark.mean, T);
    with_model(z, [&](auto model) {
      const Eigen::Vector3d residual = model.difference(z.value, model.predict(p));
      const Eigen::Vector3d weighted = S_inverse * residual;
      const double distance2 = residual.dot(weighted);
      const double robust = distance2 > huber_ * huber_ ? huber_ / std::sqrt(distance2) : 1;
      if constexpr (std::is_same_v<decltype(model), PointModel>) {
        information += Space::normal_matrix(robust * S_inverse, p);
        gradient += Space::wrench(robust * weighted, p);
      } else {
        const Eigen::Matrix3d G = model.jacobian(p);
        information += robust * Space::normal_matrix(sandwiched(G.transpose(), S_inverse), p);
        gradient += robust * Space::wrench(G.transpose() * weighted, p);
      }
    });
  }

  int iterations_;
  double huber_;
  Matrix prior_information_;
  double prior_log_root_;
  mutable std::vector<Eigen::Matrix3d> weights_;  // scratch: one proposal serves one thread
};

template <int D>
PoseGaussian posterior_of(const FastSlamSettings& settings, const Matrix6d& Q,
                          const Eigen::Isometry3d& T_prior,
                          const std::vector<ObservedLandmark>& observations) {
  const auto q = MeasurementProposal<D>(settings, Q).posterior(T_prior, observations);
  using Matrix = typename PoseSpace<D>::Matrix;
  Matrix covariance;
  for (int i = 0; i < D; ++i) covariance.col(i) = q.root.solve(Matrix::Identity().col(i));
  return {T_prior * se3_exp(PoseSpace<D>::expand(q.mean)), PoseSpace<D>::expand(covariance)};
}

template <int D>
std::unique_ptr<Proposal> make(const FastSlamSettings& settings, const Matrix6d& Q) {
  if (settings.proposal == ProposalKind::motion) return std::make_unique<MotionProposal<D>>(Q);
  return std::make_unique<MeasurementProposal<D>>(settings, Q);
}

}  // namespace

std::unique_ptr<Proposal> make_proposal(const FastSlamSettings& settings, const Matrix6d& Q) {
  return settings.planar ? make<3>(settings, Q) : make<6>(settings, Q);
}

PoseGaussian measurement_posterior(const FastSlamSettings& settings, const Matrix6d& Q,
                                   const Eigen::Isometry3d& T_prior,
                                   const std::vector<ObservedLandmark>& observations) {
  return settings.planar ? posterior_of<3>(settings, Q, T_prior, observations)
                         : posterior_of<6>(settings, Q, T_prior, observations);
}

}  // namespace lcmslam
