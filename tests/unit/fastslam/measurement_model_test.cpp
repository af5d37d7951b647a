// Planar and range-bearing measurements: Jacobians, initialisation, the landmark's filter.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include <lcmslam/fastslam/landmarks/landmark_filter.hpp>
#include <lcmslam/fastslam/proposal.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

const MeasurementKind kinds[] = {MeasurementKind::point, MeasurementKind::planar,
                                 MeasurementKind::range_bearing};

int dimension(MeasurementKind kind) {
  return with_model(kind, [](auto model) { return decltype(model)::dimension; });
}

Eigen::Matrix3d jacobian(MeasurementKind kind, const Eigen::Vector3d& p) {
  return with_model(kind, [&](auto model) -> Eigen::Matrix3d { return model.jacobian(p); });
}

Eigen::Vector3d difference(MeasurementKind kind, const Eigen::Vector3d& z, const Eigen::Vector3d& h) {
  return with_model(kind, [&](auto model) -> Eigen::Vector3d { return model.difference(z, h); });
}

// Anywhere around the robot, also behind it, where the bearing wraps.
Eigen::Vector3d random_point(Random& random) {
  const double range = random.uniform(0.3, 20), bearing = random.uniform(-M_PI, M_PI);
  return {range * std::cos(bearing), range * std::sin(bearing), 0};
}

Eigen::Isometry3d random_planar_pose(Random& random) {
  return planar_pose(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-M_PI, M_PI));
}

// Of a measurement with sigmas 5 cm and, along the second component, 5 cm or 0.02 rad.
Measurement make_measurement(MeasurementKind kind, const Eigen::Vector3d& value) {
  Measurement m;
  m.kind = kind;
  m.value = value;
  const double second = kind == MeasurementKind::range_bearing ? 0.02 : 0.05;
  m.covariance =
      Eigen::Vector3d(0.05 * 0.05, second * second, dimension(kind) == 3 ? 0.05 * 0.05 : 1).asDiagonal();
  return m;
}

TEST(MeasurementModel, LandmarkJacobianIsTheNumericOne) {
  for (const MeasurementKind kind : kinds)
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
      Random random(seed);
      const Eigen::Isometry3d T = random_planar_pose(random);
      const Eigen::Vector3d m = T * random_point(random);
      Eigen::Matrix3d numeric;
      for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(i);
        numeric.col(i) =
            difference(kind, predict_measurement(kind, m + step, T), predict_measurement(kind, m - step, T)) /
            2e-6;
      }
      const Eigen::Matrix3d H = jacobian(kind, predict_measurement(m, T)) * T.linear().transpose();
      EXPECT_LT((H - numeric).norm(), 1e-7) << "seed " << seed << " kind " << static_cast<int>(kind);
    }
}

template <int D>
void expect_numeric_pose_jacobian() {
  using Space = PoseSpace<D>;
  for (const MeasurementKind kind : kinds)
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
      Random random(seed);
      const Eigen::Isometry3d T = random_planar_pose(random);
      const Eigen::Vector3d m = T * random_point(random);
      const auto J = residual_jacobian<D>(kind, predict_measurement(m, T));
      for (int i = 0; i < D; ++i) {
        typename Space::Vector step = Space::Vector::Zero();
        step(i) = 1e-6;
        const Eigen::Vector3d minus = predict_measurement(kind, m, T * se3_exp(-Space::expand(step)));
        const Eigen::Vector3d plus = predict_measurement(kind, m, T * se3_exp(Space::expand(step)));
        const Eigen::Vector3d numeric = difference(kind, minus, plus) / 2e-6;  // residual = z - h
        EXPECT_LT((J.col(i) - numeric).norm(), 1e-6) << "seed " << seed << " component " << i;
      }
    }
}

TEST(MeasurementModel, PoseJacobianIsTheNumericOneInThePlane) {
  expect_numeric_pose_jacobian<3>();
}

TEST(MeasurementModel, PoseJacobianIsTheNumericOneInSpace) {
  expect_numeric_pose_jacobian<6>();
}

TEST(MeasurementModel, BearingsWrap) {
  const Eigen::Vector3d a(3, M_PI - 0.01, 0), b(3, -M_PI + 0.02, 0);
  EXPECT_NEAR(difference(MeasurementKind::range_bearing, a, b).y(), -0.03, 1e-12);
  EXPECT_NEAR(difference(MeasurementKind::range_bearing, b, a).y(), 0.03, 1e-12);
}

TEST(MeasurementModel, NewLandmarkIsWhereItWasMeasuredWithThatNoise) {
  for (const MeasurementKind kind : kinds)
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      Random random(seed);
      const Eigen::Isometry3d T = random_planar_pose(random);
      const Eigen::Vector3d truth = T * random_point(random);
      const Measurement z = make_measurement(kind, predict_measurement(kind, truth, T));
      const LandmarkGaussian m = make_landmark(z, T);
      EXPECT_LT((m.mean - truth).norm(), 1e-9) << "seed " << seed;
      // H Sigma H^T over the measured components is the measurement's covariance.
      const Eigen::Matrix3d H = jacobian(kind, predict_measurement(truth, T)) * T.linear().transpose();
      const Eigen::Matrix3d back = H * m.covariance * H.transpose();
      const int n = dimension(kind);
      EXPECT_TRUE(back.topLeftCorner(n, n).isApprox(z.covariance.topLeftCorner(n, n), 1e-9));
      EXPECT_GT(m.covariance.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0);
    }
}

TEST(MeasurementModel, DensityIsThatOfTheMeasuredComponents) {
  const Eigen::Isometry3d T = planar_pose(1, 2, 0.3);
  const LandmarkGaussian landmark{T * Eigen::Vector3d(3, 1, 0), 0.01 * Eigen::Matrix3d::Identity()};
  const Eigen::Vector3d h = predict_measurement(MeasurementKind::range_bearing, landmark.mean, T);
  const Measurement z = make_measurement(MeasurementKind::range_bearing, h + Eigen::Vector3d(0.1, -0.03, 0));
  const Eigen::Matrix<double, 2, 3> H =
      (jacobian(z.kind, Eigen::Vector3d(3, 1, 0)) * T.linear().transpose()).topRows<2>();
  const Eigen::Matrix2d S = H * landmark.covariance * H.transpose() + z.covariance.topLeftCorner<2, 2>();
  const Eigen::Vector2d v(0.1, -0.03);
  const Innovation innovation = innovate(landmark, z, T);
  EXPECT_NEAR(innovation.distance2, v.dot(S.inverse() * v), 1e-9);
  EXPECT_NEAR(std::exp(innovation.log_peak), 1 / (2 * M_PI * std::sqrt(S.determinant())), 1e-6);
}

Measurement bearing_of(const Eigen::Vector3d& p, const Eigen::Isometry3d& T_robot_camera, double sigma) {
  Measurement z;
  z.kind = MeasurementKind::bearing;
  z.T_robot_camera = &T_robot_camera;
  z.value = BearingModel{&T_robot_camera}.predict(p);
  z.covariance.diagonal() << sigma * sigma, sigma * sigma, 1;
  return z;
}

TEST(BearingModel, JacobianIsNumeric) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const Eigen::Isometry3d T_robot_camera = random_planar_pose(random) * optical_axes();
    const BearingModel model{&T_robot_camera};
    const Eigen::Vector3d q(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0.5, 4));
    const Eigen::Vector3d p = T_robot_camera * q;
    EXPECT_TRUE(model.predict(p).isApprox(Eigen::Vector3d(q.x() / q.z(), q.y() / q.z(), 0), 1e-9));
    Eigen::Matrix3d G;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(i);
      G.col(i) = (model.predict(p + step) - model.predict(p - step)) / 2e-6;
    }
    EXPECT_LT((model.jacobian(p) - G).norm(), 1e-6 * (1 + G.norm())) << "seed " << seed;
  }
}

// A landmark that two bearings see from the sides becomes sharp in all directions; along one ray nothing is
// learned.
TEST(BearingModel, SharpensAcrossTheRayAlone) {
  const Eigen::Isometry3d T_robot_camera = optical_axes();
  const Eigen::Vector3d truth(3, 0.2, 0.1);
  LandmarkGaussian landmark{truth + Eigen::Vector3d(0.05, -0.04, 0.03), 0.01 * Eigen::Matrix3d::Identity()};
  const Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  Measurement z = bearing_of(T.inverse() * truth, T_robot_camera, 1e-3);
  landmark = update_landmark(landmark, innovate(landmark, z, T), z, T, 0);
  const Eigen::Vector3d ray = truth.normalized();
  EXPECT_NEAR(ray.dot(landmark.covariance * ray), 0.01, 2e-4);
  EXPECT_LT(landmark.covariance.trace(), 0.0101);
  EXPECT_LT((landmark.mean - truth - ray * ray.dot(landmark.mean - truth)).norm(), 2e-3);

  const Eigen::Isometry3d T_side = planar_pose(3, -3, M_PI / 2);
  z = bearing_of(T_side.inverse() * truth, T_robot_camera, 1e-3);
  landmark = update_landmark(landmark, innovate(landmark, z, T_side), z, T_side, 0);
  EXPECT_LT((landmark.mean - truth).norm(), 0.01);
  EXPECT_LT(landmark.covariance.trace(), 5e-5);
  EXPECT_EQ(landmark.covariance, landmark.covariance.transpose().eval());
}

TEST(BearingModel, BehindTheCameraNothingFits) {
  const Eigen::Isometry3d T_robot_camera = optical_axes(), T = Eigen::Isometry3d::Identity();
  const Measurement z = bearing_of({3, 0.1, 0}, T_robot_camera, 1e-3);
  const LandmarkGaussian behind{{-3, -0.1, 0}, 1e-4 * Eigen::Matrix3d::Identity()};
  EXPECT_GT(innovate(behind, z, T).distance2, 11);
  EXPECT_TRUE(std::isfinite(innovate(behind, z, T).distance2));
  EXPECT_THROW(make_landmark(z, T), std::invalid_argument);
}

// The 2.0 proposal from bearings alone: pose and covariance of the linearised problem.
TEST(BearingModel, ProposalUsesIt) {
  FastSlamSettings settings;
  settings.planar = false;
  settings.proposal_iterations = 5;
  settings.huber_width = 1e6;
  const Eigen::Isometry3d T_robot_camera = Eigen::Translation3d(0.1, 0, 1) * optical_axes();
  Random random(3);
  const Eigen::Isometry3d T = random_planar_pose(random);
  std::vector<ObservedLandmark> seen;
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector3d q(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(1, 4));
    const Eigen::Vector3d p = T_robot_camera * q;
    seen.push_back({bearing_of(p, T_robot_camera, 1e-3), {T * p, 1e-10 * Eigen::Matrix3d::Identity()}});
  }
  Vector6d off;
  off << 0.02, -0.01, 0.03, 0.01, -0.02, 0.01;
  const Matrix6d Q = 0.01 * Matrix6d::Identity();
  const PoseGaussian posterior = measurement_posterior(settings, Q, T * se3_exp(off), seen);
  EXPECT_LT(se3_log(T.inverse() * posterior.T_world_robot).norm(), 1e-3);
  Matrix6d information = Q.inverse();
  for (const auto& o : seen) {
    const auto J = residual_jacobian<6>(o.measurement, predict_measurement(o.landmark.mean, T));
    information += J.transpose() * o.measurement.covariance.inverse() * J;
  }
  EXPECT_TRUE(posterior.covariance.isApprox(information.inverse(), 0.02));
}

// Any number of planar offsets from any poses: the information form in one go gives the same.
TEST(MeasurementModel, PlanarSequenceEqualsClosedForm) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
    LandmarkGaussian landmark;
    for (int i = 0; i < 30; ++i) {
      const Eigen::Isometry3d T = random_planar_pose(random);
      Eigen::Vector3d value = T.inverse() * Eigen::Vector3d(2, -1, 0);
      value.head<2>() += 0.05 * Eigen::Vector2d(random.normal(), random.normal());
      Measurement z = make_measurement(MeasurementKind::planar, value);
      z.covariance.topLeftCorner<2, 2>() << 0.01, 0.002, 0.002, 0.003;
      landmark = i == 0 ? make_landmark(z, T) : update_landmark(landmark, innovate(landmark, z, T), z, T, 0);
      const Eigen::Matrix2d R = T.linear().topLeftCorner<2, 2>();
      const Eigen::Matrix2d W = (R * z.covariance.topLeftCorner<2, 2>() * R.transpose()).inverse();
      information += W;
      weighted += W * (T * z.value).head<2>();
    }
    const Eigen::Matrix2d expected = information.inverse();
    EXPECT_TRUE(Eigen::Matrix2d(landmark.covariance.topLeftCorner<2, 2>()).isApprox(expected, 1e-6));
    EXPECT_TRUE(Eigen::Vector2d(landmark.mean.head<2>()).isApprox(expected * weighted, 1e-6));
    EXPECT_EQ(landmark.mean.z(), 0) << "a planar landmark stays in the plane";
  }
}

TEST(MeasurementModel, RangeBearingFilterIsConsistent) {
  double nees = 0;
  constexpr int seeds = 300;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Random random(seed);
    const Eigen::Vector3d truth(1, 2, 0);
    LandmarkGaussian landmark;
    for (int i = 0; i < 15; ++i) {
      const Eigen::Isometry3d T =
          planar_pose(random.uniform(-4, -1), random.uniform(-4, 4), random.uniform(-3, 3));
      Measurement z = make_measurement(MeasurementKind::range_bearing,
                                       predict_measurement(MeasurementKind::range_bearing, truth, T));
      z.value.x() += 0.05 * random.normal();
      z.value.y() += 0.02 * random.normal();
      landmark = i == 0 ? make_landmark(z, T) : update_landmark(landmark, innovate(landmark, z, T), z, T, 0);
    }
    const Eigen::Vector2d e = (landmark.mean - truth).head<2>();
    const Eigen::Matrix2d C = landmark.covariance.topLeftCorner<2, 2>();
    nees += e.dot(C.inverse() * e) / seeds;
  }
  EXPECT_NEAR(nees, 2, 0.35);  // chi-square of two degrees: 3.5 standard errors of the mean of 300 runs
}

TEST(MeasurementModel, PlanarCovarianceStaysSymmetricAndPositiveForMillionUpdates) {
  Random random(2);
  Measurement z = make_measurement(MeasurementKind::range_bearing, Eigen::Vector3d(5, 0.2, 0));
  z.covariance.topLeftCorner<2, 2>() = Eigen::Vector2d(1e-2, 1e-8).asDiagonal();  // very unequal
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 64; ++i) poses.push_back(random_planar_pose(random));
  LandmarkGaussian landmark = make_landmark(z, planar_pose(20, 0, 1));
  for (int i = 0; i < 1'000'000; ++i) {
    const Eigen::Isometry3d& T = poses[static_cast<std::size_t>(i % 64)];
    z.value = predict_measurement(z.kind, landmark.mean, T);
    landmark = update_landmark(landmark, innovate(landmark, z, T), z, T, 0);
  }
  ASSERT_TRUE(landmark.covariance.allFinite());
  EXPECT_EQ(landmark.covariance, landmark.covariance.transpose().eval());
  EXPECT_GT(landmark.covariance.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0);
}

// The 2.0 proposal of a planar pose from range and bearing: its covariance is the inverse information.
TEST(MeasurementModel, ProposalUsesTheModelsJacobians) {
  FastSlamSettings settings;
  settings.proposal_iterations = 5;
  settings.huber_width = 1e6;
  const Eigen::Isometry3d T = planar_pose(0.5, -0.2, 0.4);
  Matrix6d Q = Matrix6d::Identity() * 0.04;
  std::vector<ObservedLandmark> seen;
  Random random(5);
  for (int i = 0; i < 6; ++i) {
    ObservedLandmark o;
    const Eigen::Vector3d p = random_point(random);
    o.landmark.mean = T * p;
    o.landmark.covariance = 1e-10 * Eigen::Matrix3d::Identity();
    o.measurement = make_measurement(MeasurementKind::range_bearing,
                                     predict_measurement(MeasurementKind::range_bearing, o.landmark.mean, T));
    seen.push_back(o);
  }
  const Eigen::Isometry3d T_prior = T * planar_pose(0.1, -0.05, 0.05);
  const PoseGaussian posterior = measurement_posterior(settings, Q, T_prior, seen);
  Eigen::Matrix3d information = PoseSpace<3>::reduce(Q).inverse();
  for (const auto& o : seen) {
    const auto J = residual_jacobian<3>(o.measurement.kind, predict_measurement(o.landmark.mean, T));
    information += J.transpose() * o.measurement.covariance.inverse() * J;
  }
  const Eigen::Isometry3d error = T.inverse() * posterior.T_world_robot;
  EXPECT_LT(error.translation().norm(), 0.01);
  EXPECT_LT(std::abs(yaw(error)), 0.01);
  EXPECT_TRUE(PoseSpace<3>::reduce(posterior.covariance).isApprox(information.inverse(), 0.02));
}

}  // namespace
}  // namespace lcmslam
