#include <lcmslam/odometry/motion_noise.hpp>

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <vector>

namespace lcmslam {
namespace {

std::vector<MotionSample> path(int samples, Utime period) {
  std::vector<MotionSample> result;
  for (int i = 0; i < samples; ++i) {
    MotionSample sample;
    sample.utime = 5'000'000 + i * period;
    const double s = 1e-6 * static_cast<double>(i * period);
    sample.T_odom_robot = planar_pose(std::cos(s), std::sin(s), s);
    sample.covariance = s * Matrix6d::Identity();
    result.push_back(sample);
  }
  return result;
}

Eigen::Vector3d offset(const MotionSample& noisy, const MotionSample& clean) {
  return noisy.T_odom_robot.translation() - clean.T_odom_robot.translation();
}

TEST(MotionNoise, OfSigmaZeroChangesNothing) {
  for (const auto mode : {MotionNoiseMode::random_walk, MotionNoiseMode::white}) {
    MotionNoise noise({mode, Eigen::Vector3d::Zero(), 10}, Random(1));
    for (const MotionSample& sample : path(50, 33'000)) {
      const MotionSample noisy = noise.apply(sample);
      EXPECT_EQ(noisy.T_odom_robot.matrix(), sample.T_odom_robot.matrix());
      EXPECT_EQ(noisy.covariance, sample.covariance);
    }
  }
}

TEST(MotionNoise, TouchesThePositionOnly) {
  MotionNoise noise({}, Random(1));
  for (MotionSample sample : path(50, 100'000)) {
    sample.visual = true;
    const MotionSample noisy = noise.apply(sample);
    EXPECT_EQ(noisy.utime, sample.utime);
    EXPECT_TRUE(noisy.visual);
    EXPECT_EQ(noisy.T_odom_robot.linear(), sample.T_odom_robot.linear());
    EXPECT_EQ(offset(noisy, sample).z(), 0);
  }
}

TEST(MotionNoise, WalkGrowsWithTheRootOfTimeAndWhiteDoesNot) {
  constexpr int seeds = 2000, draws = 50;
  const auto clean = path(draws + 1, 100'000);
  for (const auto mode : {MotionNoiseMode::random_walk, MotionNoiseMode::white}) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero(), square = Eigen::Vector3d::Zero();
    for (int seed = 0; seed < seeds; ++seed) {
      MotionNoise noise({mode, {0.02, 0.04, 0.01}, 10}, Random(static_cast<std::uint64_t>(seed)));
      Eigen::Vector3d last = Eigen::Vector3d::Zero();
      for (const MotionSample& sample : clean) last = offset(noise.apply(sample), sample);
      mean += last / seeds;
      square += last.cwiseAbs2() / seeds;
    }
    const double growth = mode == MotionNoiseMode::random_walk ? std::sqrt(double(draws)) : 1;
    const Eigen::Vector3d sigma = growth * Eigen::Vector3d(0.02, 0.04, 0.01);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(std::sqrt(square[axis]) / sigma[axis], 1, 0.06);  // 4 sigma of 2000 draws
      EXPECT_NEAR(mean[axis] / sigma[axis], 0, 0.09);
    }
  }
}

TEST(MotionNoise, CovarianceOfIncrementsIsWhatWasAdded) {
  const Eigen::Vector3d sigma(0.02, 0.04, 0.01);
  auto clean = path(31, 100'000);
  for (MotionSample& sample : clean) sample.covariance.setZero();
  for (const auto mode : {MotionNoiseMode::random_walk, MotionNoiseMode::white}) {
    MotionNoise noise({mode, sigma, 10}, Random(3));
    MotionBuffer buffer;
    for (const MotionSample& sample : clean) buffer.add(noise.apply(sample));
    const auto motion = buffer.between(clean[9].utime, clean[10].utime);
    ASSERT_TRUE(motion);
    // In the odometry frame: the walk's step, or the difference of two independent draws.
    const Eigen::Matrix3d R = clean[10].T_odom_robot.linear();
    const Eigen::Vector3d variance = (mode == MotionNoiseMode::random_walk ? 1.0 : 2.0) * sigma.cwiseAbs2();
    const Eigen::Matrix3d added = R * motion->covariance.topLeftCorner<3, 3>() * R.transpose();
    EXPECT_TRUE(added.isApprox(Eigen::Matrix3d(variance.asDiagonal()), 1e-9)) << added;
    EXPECT_LT((motion->covariance.bottomRows<3>().norm()), 1e-12);
  }
}

// Also where the path's own heading has become uncertain: then a sideways step of the noise makes a lever.
TEST(MotionNoise, CovarianceOfIncrementsIsPositive) {
  auto clean = path(300, 20'000);
  for (std::size_t i = 0; i < clean.size(); ++i) {
    clean[i].covariance = 1e-12 * Matrix6d::Identity();
    if (i == 0) continue;
    const Matrix6d A = adjoint(clean[i].T_odom_robot.inverse() * clean[i - 1].T_odom_robot);
    clean[i].covariance = A * clean[i - 1].covariance * A.transpose() + 1e-4 * Matrix6d::Identity();
  }
  for (const auto mode : {MotionNoiseMode::random_walk, MotionNoiseMode::white}) {
    MotionNoise noise({mode, Eigen::Vector3d(0.02, 0.02, 0), 10}, Random(3));
    std::optional<MotionSample> a;
    for (const MotionSample& sample : clean) {
      const MotionSample b = noise.apply(sample);
      if (a) {
        const Matrix6d A = adjoint(b.T_odom_robot.inverse() * a->T_odom_robot);
        const Matrix6d Q = b.covariance - A * a->covariance * A.transpose();
        const double least = Eigen::SelfAdjointEigenSolver<Matrix6d>(Q).eigenvalues().minCoeff();
        ASSERT_NEAR(least, 1e-4, 1e-6);  // the path's own, as if no noise were there
      }
      a = b;
    }
  }
}

TEST(MotionNoise, DoesNotDependOnTheMessagesBetween) {
  auto clean = path(201, 10'000);
  for (MotionSample& sample : clean) sample.covariance.setZero();  // the path's own moves with the noise
  MotionNoise all({}, Random(9)), few({}, Random(9));
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const MotionSample a = all.apply(clean[i]);
    if (i % 40 != 0) continue;
    const MotionSample b = few.apply(clean[i]);
    EXPECT_EQ(a.T_odom_robot.matrix(), b.T_odom_robot.matrix()) << i;
    EXPECT_TRUE(a.covariance.isApprox(b.covariance, 1e-12) || i == 0);
  }
}

TEST(MotionNoise, StampsThatGoBackStartANewPath) {
  MotionNoise noise({}, Random(2));
  const auto clean = path(100, 100'000);
  for (const MotionSample& sample : clean) noise.apply(sample);
  EXPECT_EQ(offset(noise.apply(clean.front()), clean.front()), Eigen::Vector3d::Zero());
}

TEST(MotionNoise, SettingsAreChecked) {
  EXPECT_THROW(MotionNoise({MotionNoiseMode::white, {-1, 0, 0}, 10}, Random(1)), std::invalid_argument);
  EXPECT_THROW(
      MotionNoise({MotionNoiseMode::white, {0, 0, std::numeric_limits<double>::quiet_NaN()}, 10}, Random(1)),
      std::invalid_argument);
  EXPECT_THROW(MotionNoise({MotionNoiseMode::white, {0, 0, 0}, 0}, Random(1)), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
