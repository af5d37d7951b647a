#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include <lcmslam/fastslam/landmarks/symmetric.hpp>
#include <lcmslam/fastslam/pose_space.hpp>
#include <lcmslam/fastslam/proposal.hpp>

namespace lcmslam {
namespace {

std::vector<ObservedLandmark> random_observations(Random& random, const Eigen::Isometry3d& T_true, int count,
                                                  double sigma) {
  std::vector<ObservedLandmark> observations;
  for (int i = 0; i < count; ++i) {
    ObservedLandmark o;
    o.measurement.value << random.uniform(0.5, 5), random.uniform(-2, 2), random.uniform(0, 2);
    o.measurement.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
    o.landmark.mean = T_true * o.measurement.value;
    o.landmark.covariance = 0.5 * o.measurement.covariance;
    const double total = sigma * std::sqrt(1.5);
    o.measurement.value += total * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    observations.push_back(o);
  }
  return observations;
}

Matrix6d prior_covariance(double translation, double rotation) {
  Matrix6d Q = Matrix6d::Zero();
  Q.diagonal().head<3>().setConstant(translation * translation);
  Q.diagonal().tail<3>().setConstant(rotation * rotation);
  Q(0, 5) = Q(5, 0) = 0.5 * translation * rotation;
  return Q;
}

template <int D>
void check_jacobian() {
  using Space = PoseSpace<D>;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Vector6d twist;
    for (int i = 0; i < 6; ++i) twist(i) = random.normal();
    const Eigen::Isometry3d T = se3_exp(twist);
    const Eigen::Vector3d m(random.normal(), random.normal(), random.normal());
    const auto J = Space::residual_jacobian(predict_measurement(m, T));
    for (int i = 0; i < D; ++i) {
      const typename Space::Vector step = 1e-6 * Space::Vector::Unit(i);
      const Eigen::Vector3d plus = -predict_measurement(m, T * se3_exp(Space::expand(step)));
      const Eigen::Vector3d minus = -predict_measurement(m, T * se3_exp(-Space::expand(step)));
      EXPECT_LT(((plus - minus) / 2e-6 - J.col(i)).norm(), 1e-8) << "seed " << seed << " column " << i;
    }
  }
}

template <int D>
void check_normal_matrix() {
  using Space = PoseSpace<D>;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Eigen::Matrix3d A;
    for (int i = 0; i < 9; ++i) A(i) = random.normal();
    const Eigen::Matrix3d W = A * A.transpose();
    const Eigen::Vector3d h(random.normal(), random.normal(), random.normal()), g = A.col(1);
    const auto J = Space::residual_jacobian(h);
    EXPECT_TRUE(Space::normal_matrix(W, h).isApprox(J.transpose() * W * J, 1e-12)) << "seed " << seed;
    EXPECT_TRUE(Space::wrench(g, h).isApprox(J.transpose() * g, 1e-12)) << "seed " << seed;
    EXPECT_TRUE(sandwiched(A, W).isApprox(A * W * A.transpose(), 1e-12)) << "seed " << seed;
    const SymmetricInverse inverse = invert_symmetric(W);
    EXPECT_TRUE(inverse.inverse.isApprox(W.inverse(), 1e-6)) << "seed " << seed;
    EXPECT_NEAR(inverse.determinant, W.determinant(), 1e-9 * W.norm() * W.norm() * W.norm());
    EXPECT_EQ(inverse.inverse, inverse.inverse.transpose().eval());
  }
}

TEST(Proposal, NormalMatrixIsWrittenOutRightly) {
  check_normal_matrix<3>();
  check_normal_matrix<6>();
}

TEST(Proposal, ResidualJacobiansAreNumericDerivatives) {
  check_jacobian<3>();
  check_jacobian<6>();
}

// Moments of drawn poses relative to a centre.
struct Moments {
  Vector6d mean = Vector6d::Zero();
  Matrix6d covariance = Matrix6d::Zero();
};
Moments draw(const Proposal& proposal, const Eigen::Isometry3d& T_prior, const Eigen::Isometry3d& T_centre,
             const std::vector<ObservedLandmark>& observations, int count) {
  Random random(11);
  Moments m;
  for (int i = 0; i < count; ++i) {
    const Vector6d xi =
        se3_log(T_centre.inverse() * proposal.propose(T_prior, observations, random).T_world_robot);
    m.mean += xi / count;
    m.covariance += xi * xi.transpose() / count;
  }
  m.covariance -= m.mean * m.mean.transpose();
  return m;
}

TEST(Proposal, MotionProposalDrawsThePrior) {
  FastSlamSettings settings;
  settings.proposal = ProposalKind::motion;
  const Matrix6d Q = prior_covariance(0.05, 0.02);
  const Eigen::Isometry3d T = planar_pose(1, 2, 0.5);
  for (const bool planar : {true, false}) {
    settings.planar = planar;
    const Moments m = draw(*make_proposal(settings, Q), T, T, {}, 20000);
    Matrix6d expected = Q;
    if (planar) expected = PoseSpace<3>::expand(PoseSpace<3>::reduce(Q));
    EXPECT_LT((m.covariance - expected).cwiseAbs().maxCoeff(), 0.05 * 0.0025) << planar;
    EXPECT_LT(m.mean.norm(), 0.002) << planar;
  }
}

TEST(Proposal, MeasurementProposalDrawsItsPosterior) {
  for (const bool planar : {true, false}) {
    FastSlamSettings settings;
    settings.planar = planar;
    Random random(3);
    const Eigen::Isometry3d T_prior = planar_pose(1, 2, 0.5);
    const auto observations = random_observations(random, T_prior * planar_pose(0.02, -0.03, 0.01), 15, 0.02);
    const Matrix6d Q = prior_covariance(0.05, 0.02);
    const PoseGaussian posterior = measurement_posterior(settings, Q, T_prior, observations);
    const Moments m =
        draw(*make_proposal(settings, Q), T_prior, posterior.T_world_robot, observations, 20000);
    const double scale = posterior.covariance.diagonal().maxCoeff();
    EXPECT_LT((m.covariance - posterior.covariance).cwiseAbs().maxCoeff(), 0.05 * scale) << planar;
    EXPECT_LT(m.mean.norm(), 0.05 * std::sqrt(scale)) << planar;
  }
}

// Small angles, no outliers: the problem is linear and the posterior has a closed form.
TEST(Proposal, PosteriorEqualsLinearGaussianFormula) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    FastSlamSettings settings;
    settings.huber_width = 1e3;
    settings.planar = false;
    const Matrix6d Q = prior_covariance(1e-3, 5e-4);
    Vector6d offset;
    for (int i = 0; i < 6; ++i) offset(i) = (i < 3 ? 1e-3 : 5e-4) * random.normal();
    const auto observations = random_observations(random, se3_exp(offset), 8, 2e-3);
    Matrix6d information = Q.inverse();
    Vector6d vector = Vector6d::Zero();
    for (const auto& o : observations) {
      Eigen::Matrix<double, 3, 6> J;
      J << Eigen::Matrix3d::Identity(), -hat(o.landmark.mean);
      const Eigen::Matrix3d W = (o.landmark.covariance + o.measurement.covariance).inverse();
      information += J.transpose() * W * J;
      vector -= J.transpose() * W * (o.measurement.value - o.landmark.mean);
    }
    const Vector6d expected = information.inverse() * vector;
    const PoseGaussian posterior =
        measurement_posterior(settings, Q, Eigen::Isometry3d::Identity(), observations);
    EXPECT_LT((se3_log(posterior.T_world_robot) - expected).norm(), 2e-5) << "seed " << seed;
    EXPECT_LT((posterior.covariance - information.inverse()).norm(), 0.01 * information.inverse().norm())
        << "seed " << seed;
  }
}

// p(z | x) p(x) / q(x) is the evidence p(z), whatever x was drawn, when everything is Gaussian.
TEST(Proposal, ImportanceWeightDoesNotDependOnTheDraw) {
  for (const bool planar : {true, false}) {
    FastSlamSettings settings;
    settings.planar = planar;
    settings.huber_width = 1e3;
    settings.proposal_iterations = 5;
    Random random(8);
    const auto observations = random_observations(random, Eigen::Isometry3d::Identity(), 10, 3e-3);
    const auto proposal = make_proposal(settings, prior_covariance(3e-3, 2e-3));
    double low = 1e9, high = -1e9;
    for (int i = 0; i < 200; ++i) {
      const ProposedPose p = proposal->propose(Eigen::Isometry3d::Identity(), observations, random);
      double log_weight = p.log_weight;
      for (const auto& o : observations) {
        const Innovation v = innovate(o.landmark, o.measurement, p.T_world_robot);
        log_weight += v.log_peak - 0.5 * v.distance2;
      }
      low = std::min(low, log_weight);
      high = std::max(high, log_weight);
    }
    EXPECT_LT(high - low, 0.1) << planar;
  }
}

TEST(Proposal, OneWrongMatchHardlyMovesIt) {
  FastSlamSettings settings;
  Random random(4);
  auto observations = random_observations(random, Eigen::Isometry3d::Identity(), 20, 0.01);
  const Matrix6d Q = prior_covariance(0.05, 0.02);
  const auto T_clean =
      measurement_posterior(settings, Q, Eigen::Isometry3d::Identity(), observations).T_world_robot;
  observations[7].landmark.mean += Eigen::Vector3d(0.8, -0.5, 0);
  const auto T_wrong =
      measurement_posterior(settings, Q, Eigen::Isometry3d::Identity(), observations).T_world_robot;
  EXPECT_LT((T_clean.translation() - T_wrong.translation()).norm(), 0.005);
}

}  // namespace
}  // namespace lcmslam
