#include <lcmslam/fastslam/proposal.hpp>

#include <Eigen/Cholesky>
#include <cmath>

#include <lcmslam/fastslam/landmarks/small_cholesky.hpp>
#include <lcmslam/fastslam/landmarks/symmetric.hpp>
#include <lcmslam/fastslam/pose_space.hpp>
#include <lcmslam/fastslam/proposal_equations.hpp>

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"  // see lanes.hpp
#endif

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

  using Proposal::propose;
  void propose(const Eigen::Isometry3d* T_world_prior, const ObservedLanes&, Random* streams, int count,
               ProposedPose* proposed) const override {
    for (int k = 0; k < count; ++k) {
      const typename PoseSpace<D>::Vector xi = root_ * standard_normal<D>(streams[k]);
      proposed[k] = {T_world_prior[k] * se3_exp(PoseSpace<D>::expand(xi)), 0};
    }
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
  using LaneArray = typename LaneCholesky<D>::Vector;

  struct Posterior {
    LaneArray mean;        // xi
    LaneCholesky<D> root;  // of the information
  };

  MeasurementProposal(const FastSlamSettings& settings, const Matrix6d& Q)
      : iterations_(settings.proposal_iterations),
        huber_(settings.huber_width),
        prior_information_(Space::reduce(Q).llt().solve(Matrix::Identity())),
        prior_log_root_(SmallCholesky<D>(prior_information_).half_log_determinant()) {}

  void posterior(const Eigen::Isometry3d* T_prior, const ObservedLanes& observed, Posterior& result) const {
    // S_i is formed once, at the prior's orientation.
    weigh_points(observed.measurements, observed.landmarks, T_prior, weights_);
    weigh_others(observed, T_prior);
    result.mean = {};
    Eigen::Isometry3d T[lane_count];
    ProposalEquations<D> normal;
    for (int iteration = 0; iteration < iterations_; ++iteration) {
      for (int k = 0; k < lane_count; ++k)
        T[k] = iteration == 0 ? T_prior[k] : T_prior[k] * se3_exp(Space::expand(lane(result.mean, k)));
      begin(result.mean, normal);
      add_points(observed.measurements, observed.landmarks, weights_, T, huber_, normal);
      add_others(observed, T, normal);
      descend(normal, result.root, result.mean);
    }
  }

  using Proposal::propose;
  void propose(const Eigen::Isometry3d* T_prior, const ObservedLanes& observed, Random* streams, int count,
               ProposedPose* proposed) const override {
    Posterior q;
    posterior(T_prior, observed, q);
    LaneArray xi{};
    Vector normal[lane_count];
    for (int k = 0; k < count; ++k) {
      normal[k] = standard_normal<D>(streams[k]);
      for (int i = 0; i < D; ++i) xi[static_cast<std::size_t>(i)][k] = normal[k](i);
    }
    q.root.solve_upper(xi);
    for (int k = 0; k < count; ++k) {
      const Vector drawn = lane(q.mean, k) + lane(xi, k);
      const double log_prior = prior_log_root_ - 0.5 * drawn.dot(prior_information_ * drawn);
      const double log_proposal = q.root.half_log_determinant(k) - 0.5 * normal[k].squaredNorm();
      proposed[k] = {T_prior[k] * se3_exp(Space::expand(drawn)), log_prior - log_proposal};
    }
  }

 private:
  static Vector lane(const LaneArray& lanes, int k) {
    Vector v;
    for (int i = 0; i < D; ++i) v(i) = lanes[static_cast<std::size_t>(i)][k];
    return v;
  }

  // The prior's part.
  void begin(const LaneArray& mean, ProposalEquations<D>& normal) const {
    for (std::size_t i = 0; i < D; ++i) {
      normal.gradient[i] = Lanes{};
      for (std::size_t j = 0; j < D; ++j) {
        const double information = prior_information_(static_cast<int>(i), static_cast<int>(j));
        normal.gradient[i] += information * mean[j];
        normal.information[i][j] = information + Lanes{};
      }
    }
  }

  // What is no point, particle by particle.
  void weigh_others(const ObservedLanes& observed, const Eigen::Isometry3d* T_prior) const {
    others_.clear();
    for (std::size_t i = 0; i < observed.measurements.size(); ++i) {
      if (observed.measurements[i].kind == MeasurementKind::point) continue;
      Other other{i, {}};
      for (int k = 0; k < lane_count; ++k)
        other.weights[k] = invert_symmetric(innovation_covariance(observed.landmarks[i].gaussian(k),
                                                                  observed.measurements[i], T_prior[k]))
                               .inverse;
      others_.push_back(other);
    }
  }

  void add_others(const ObservedLanes& observed, const Eigen::Isometry3d* T,
                  ProposalEquations<D>& normal) const {
    for (const Other& other : others_)
      for (int k = 0; k < lane_count; ++k) {
        const LandmarkGaussian landmark = observed.landmarks[other.index].gaussian(k);
        Matrix information = Matrix::Zero();
        Vector gradient = Vector::Zero();
        add(observed.measurements[other.index], landmark.mean, other.weights[k], T[k], information, gradient);
        for (std::size_t i = 0; i < D; ++i) {
          normal.gradient[i][k] += gradient(static_cast<int>(i));
          for (std::size_t j = 0; j <= i; ++j)
            normal.information[i][j][k] += information(static_cast<int>(i), static_cast<int>(j));
        }
      }
  }

  void add(const Measurement& z, const Eigen::Vector3d& landmark, const Eigen::Matrix3d& S_inverse,
           const Eigen::Isometry3d& T, Matrix& information, Vector& gradient) const {
    const Eigen::Vector3d p = predict_measurement(landmark, T);
    with_model(z, [&](auto model) {
      const Eigen::Vector3d residual = model.difference(z.value, model.predict(p));
      const Eigen::Vector3d weighted = S_inverse * residual;
      const double distance2 = residual.dot(weighted);
      const double robust = distance2 > huber_ * huber_ ? huber_ / std::sqrt(distance2) : 1;
      const Eigen::Matrix3d G = model.jacobian(p);
      information += robust * Space::normal_matrix(sandwiched(G.transpose(), S_inverse), p);
      gradient += robust * Space::wrench(G.transpose() * weighted, p);
    });
  }

  int iterations_;
  double huber_;
  Matrix prior_information_;
  double prior_log_root_;
  // Scratch: one proposal serves one thread.
  struct Other {
    std::size_t index;                    // of the measurement
    Eigen::Matrix3d weights[lane_count];  // S^-1
  };
  mutable std::vector<LaneSymmetric> weights_;
  mutable std::vector<Other> others_;
};

template <int D>
PoseGaussian posterior_of(const FastSlamSettings& settings, const Matrix6d& Q,
                          const Eigen::Isometry3d& T_prior,
                          const std::vector<ObservedLandmark>& observations) {
  const Eigen::Isometry3d T_priors[lane_count] = {T_prior, T_prior, T_prior, T_prior};
  typename MeasurementProposal<D>::Posterior q;
  MeasurementProposal<D>(settings, Q).posterior(T_priors, ObservedLanes(observations), q);
  typename PoseSpace<D>::Vector mean;
  typename PoseSpace<D>::Matrix covariance;
  for (std::size_t i = 0; i < D; ++i) {
    typename LaneCholesky<D>::Vector column{};
    column[i] += 1.;
    q.root.solve(column);
    mean(static_cast<int>(i)) = q.mean[i][0];
    for (std::size_t j = 0; j < D; ++j) covariance(static_cast<int>(j), static_cast<int>(i)) = column[j][0];
  }
  return {T_prior * se3_exp(PoseSpace<D>::expand(mean)), PoseSpace<D>::expand(covariance)};
}

template <int D>
std::unique_ptr<Proposal> make(const FastSlamSettings& settings, const Matrix6d& Q) {
  if (settings.proposal == ProposalKind::motion) return std::make_unique<MotionProposal<D>>(Q);
  return std::make_unique<MeasurementProposal<D>>(settings, Q);
}

}  // namespace

ObservedLanes::ObservedLanes(const std::vector<ObservedLandmark>& observations) {
  for (const ObservedLandmark& observed : observations) {
    measurements.push_back(observed.measurement);
    landmarks.push_back({all_lanes(observed.landmark.mean), all_lanes(observed.landmark.covariance)});
  }
}

ProposedPose Proposal::propose(const Eigen::Isometry3d& T_world_prior,
                               const std::vector<ObservedLandmark>& observations, Random& random) const {
  const Eigen::Isometry3d T_priors[lane_count] = {T_world_prior, T_world_prior, T_world_prior, T_world_prior};
  ProposedPose proposed;
  propose(T_priors, ObservedLanes(observations), &random, 1, &proposed);
  return proposed;
}

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
