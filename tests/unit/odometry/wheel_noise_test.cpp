// Does the covariance tell the truth? NEES: e^T S^-1 e has the mean n when e ~ N(0, S) in n dimensions.

#include <lcmslam/odometry/wheel_noise.hpp>

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <iostream>

#include <lcmslam/geometry/random.hpp>
#include "tests/unit/odometry/simulated_bases.hpp"

namespace lcmslam {
namespace {

// A winding path, 0.5 m/s.
PlanarTwist twist_at(int step) {
  return {0.4, 0.1 * std::sin(0.02 * step), 0.6 * std::sin(0.013 * step)};
}

Vector6d draw(const Matrix6d& covariance, Random& random) {
  Vector6d normal;
  for (int i = 0; i < 6; ++i) normal[i] = random.normal();
  return covariance.llt().matrixL() * normal;
}

double nees(const MotionSample& sample, const Eigen::Isometry3d& T_true) {
  const Vector6d error = se3_log(sample.T_odom_robot.inverse() * T_true);
  return error.dot(sample.covariance.ldlt().solve(error));
}

double planar_nees(const MotionSample& sample, const Eigen::Isometry3d& T_true) {
  const Vector6d error = se3_log(sample.T_odom_robot.inverse() * T_true);
  const int axes[3] = {0, 1, 5};
  Eigen::Vector3d e;
  Eigen::Matrix3d S;
  for (int i = 0; i < 3; ++i) {
    e[i] = error[axes[i]];
    for (int j = 0; j < 3; ++j) S(i, j) = sample.covariance(axes[i], axes[j]);
  }
  return e.dot(S.ldlt().solve(e));
}

TEST(WheelNoise, AccumulatedCovarianceIsThatOfNoiseDrawnFromTheModel) {
  const WheelNoise noise;
  constexpr int seeds = 400, steps = 500;
  constexpr double dt = 0.02;
  double sum = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    Random random(static_cast<std::uint64_t>(seed), 3);
    testing::Base base = testing::mecanum_base();
    WheelOdometry odometry;
    MotionSample sample = *odometry.update(base.encoders);
    Eigen::Isometry3d T_true = Eigen::Isometry3d::Identity();
    for (int i = 0; i < steps; ++i) {
      const PlanarTwist twist = twist_at(i);
      const MotionSample before = sample;
      testing::drive(base, twist, dt);
      sample = *odometry.update(base.encoders);
      const Matrix6d A = adjoint(sample.T_odom_robot.inverse() * before.T_odom_robot);
      const Matrix6d Q = sample.covariance - A * before.covariance * A.transpose();
      T_true = T_true * testing::arc(twist, dt) * se3_exp(draw(Q, random));
    }
    sum += nees(sample, T_true) / seeds;
  }
  EXPECT_NEAR(sum, 6, 0.7) << "4 standard deviations of the mean of " << seeds << " chi-squared values";
  std::cout << "NEES of the model's own noise: " << sum << " (6 is right)\n";
}

// The pinned simulated wheels: scales that stay for the whole run, drift, slips. The model replaces the
// constant scales by a random walk, so that it can only be right in size.
double simulated_nees(double metres, int seeds) {
  double sum = 0;
  constexpr double dt = 0.02, degree = M_PI / 180;
  for (int seed = 0; seed < seeds; ++seed) {
    Random random(static_cast<std::uint64_t>(seed), 4);
    const double scale[3] = {random.normal(0, 0.02), random.normal(0, 0.03), random.normal(0, 0.03)};
    double next_slip = random.uniform(0, 10);
    testing::Base base = testing::mecanum_base();
    WheelOdometry odometry;
    MotionSample sample = *odometry.update(base.encoders);
    Eigen::Isometry3d T_true = Eigen::Isometry3d::Identity();
    double way = 0;
    for (int i = 0; way < metres; ++i) {
      PlanarTwist twist = twist_at(i);
      testing::drive(base, twist, dt);
      sample = *odometry.update(base.encoders);
      const double step = std::hypot(twist.vx, twist.vy) * dt;
      way += step;
      Vector6d error = Vector6d::Zero();
      error << scale[0] * twist.vx * dt + random.normal(0, 0.01 * std::sqrt(step)),
          scale[1] * twist.vy * dt + random.normal(0, 0.01 * std::sqrt(step)), 0, 0, 0,
          scale[2] * twist.w * dt + random.normal(0, 0.5 * degree * std::sqrt(step));
      if (way > next_slip) {
        next_slip += random.uniform(5, 15);
        const double direction = random.uniform(-M_PI, M_PI), size = random.uniform(0.02, 0.05);
        error[0] += size * std::cos(direction);
        error[1] += size * std::sin(direction);
        error[5] += random.uniform(1, 3) * degree * (random.uniform() < 0.5 ? -1 : 1);
      }
      T_true = T_true * testing::arc(twist, dt) * se3_exp(error);
    }
    sum += planar_nees(sample, T_true) / seeds;
  }
  return sum;
}

TEST(WheelNoise, CovarianceHasTheSizeOfThePinnedSimulatedErrors) {
  for (const double metres : {1.0, 2.0, 5.0}) {
    const double mean = simulated_nees(metres, 200);
    EXPECT_GT(mean, 3 * 0.5) << metres << " m: too wide";
    EXPECT_LT(mean, 3 * 2.0) << metres << " m: too narrow";
    std::cout << "NEES of the simulated wheels after " << metres << " m: " << mean << " (3 is right)\n";
  }
  // A constant scale grows with the way, the model with its root: see wheel_noise.hpp.
  const double far = simulated_nees(20, 100);
  EXPECT_GT(far, 6) << "if this is no longer so, wheel_noise.hpp describes it wrongly";
  std::cout << "NEES of the simulated wheels after 20 m: " << far << " (3 is right)\n";
}

TEST(WheelNoise, DoesNotDependOnHowTheWayIsCut) {
  const WheelNoise noise;
  const PlanarIncrement whole{0.3, -0.4, 0.2, 0.6, 1.5};
  const PlanarIncrement half{0.15, -0.2, 0.1, 0.3, 0.75};
  EXPECT_TRUE((2 * increment_covariance(noise, half)).isApprox(increment_covariance(noise, whole), 1e-12));
}

TEST(WheelNoise, TheDistanceOfASlipHoldsOneSlip) {
  WheelNoise noise;
  noise.longitudinal_scale = noise.translation_drift = noise.rotation_drift = 0;
  const Matrix6d slip = increment_covariance(noise, {noise.slip_distance, 0, 0, noise.slip_distance, 0});
  EXPECT_NEAR(std::sqrt(slip(0, 0)), noise.slip_translation, 1e-12);
  EXPECT_NEAR(std::sqrt(slip(1, 1)), noise.slip_translation, 1e-12);
  EXPECT_NEAR(std::sqrt(slip(5, 5)), noise.slip_rotation, 1e-12);
}

TEST(WheelNoise, TyresThatHoldABaseSidewaysCanButScrub) {
  WheelNoise noise;
  noise.rest_translation = 1e-9;
  PlanarIncrement increment{0.5, 0, 0.2, 1, 1};
  const Matrix6d loose = increment_covariance(noise, increment);
  increment.held_at = Eigen::Vector2d::Zero();
  Matrix6d held = increment_covariance(noise, increment);
  EXPECT_NEAR(std::sqrt(held(1, 1)), noise.side_drift, 1e-9);
  EXPECT_GT(loose(1, 1), 16 * held(1, 1));
  held(1, 1) = loose(1, 1);
  EXPECT_EQ(held, loose) << "other axes are as they were";
}

TEST(WheelNoise, OneMetreOfScaleErrorIsTheScale) {
  WheelNoise noise;
  noise.translation_drift = noise.rotation_drift = noise.slip_translation = noise.slip_rotation = 0;
  const Matrix6d forward = increment_covariance(noise, {1, 0, 0, 1, 0});
  const Matrix6d sideways = increment_covariance(noise, {0, -1, 0, 1, 0});
  const Matrix6d turn = increment_covariance(noise, {0, 0, -1, 0, 0});
  EXPECT_NEAR(std::sqrt(forward(0, 0)), 0.02, 1e-12);
  EXPECT_NEAR(std::sqrt(sideways(1, 1)), 0.03, 1e-12);
  EXPECT_NEAR(std::sqrt(turn(5, 5)), 0.03, 1e-12);
  EXPECT_EQ(forward(1, 1), 0);
}

}  // namespace
}  // namespace lcmslam
