#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include <lcmslam/fastslam/landmarks/landmark_filter.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {
namespace {

Eigen::Vector3d random_vector(Random& random, double scale) {
  return scale * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
}

Eigen::Matrix3d random_covariance(Random& random, double scale) {
  Eigen::Matrix3d A;
  for (int i = 0; i < 9; ++i) A(i) = random.normal();
  const Eigen::Matrix3d C = A * A.transpose() + 0.1 * Eigen::Matrix3d::Identity();
  return scale * scale * C;
}

Eigen::Isometry3d random_pose(Random& random) {
  Vector6d twist;
  twist << random_vector(random, 2), random_vector(random, 0.7);
  return se3_exp(twist);
}

TEST(LandmarkFilter, PlanarModelIsTheThesisEquations) {
  const double x = 1.2, y = -0.7, theta = 0.6;
  const Eigen::Isometry3d T = planar_pose(x, y, theta);
  const Measurement z{{2, 0.5, 1.1}, Eigen::Matrix3d::Identity() * 1e-4};
  const LandmarkGaussian m = make_landmark(z, T);
  EXPECT_NEAR(m.mean.x(), 2 * std::cos(theta) - 0.5 * std::sin(theta) + x, 1e-12);  // 2.1
  EXPECT_NEAR(m.mean.y(), 2 * std::sin(theta) + 0.5 * std::cos(theta) + y, 1e-12);  // 2.2
  EXPECT_NEAR(m.mean.z(), 1.1, 1e-12);                                              // 2.3
  EXPECT_TRUE(predict_measurement(m.mean, T).isApprox(z.value, 1e-12));             // 2.6-2.8
}

TEST(LandmarkFilter, JacobianAndInitialCovariance) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const Eigen::Isometry3d T = random_pose(random);
    const Eigen::Vector3d mean = random_vector(random, 2);
    Eigen::Matrix3d G;  // numeric dh/dm
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(i);
      G.col(i) = (predict_measurement(mean + step, T) - predict_measurement(mean - step, T)) / 2e-5;
    }
    EXPECT_TRUE(G.isApprox(T.linear().transpose(), 1e-8)) << "seed " << seed;
    const Measurement z{random_vector(random, 2), random_covariance(random, 0.05)};
    const Eigen::Matrix3d expected = (G.transpose() * z.covariance.inverse() * G).inverse();  // 2.4 corrected
    EXPECT_TRUE(make_landmark(z, T).covariance.isApprox(expected, 1e-6)) << "seed " << seed;
  }
}

TEST(LandmarkFilter, DensityIsTheGaussianOf25Corrected) {
  Random random(9);
  const Eigen::Isometry3d T = random_pose(random);
  const LandmarkGaussian m{random_vector(random, 2), random_covariance(random, 0.1)};
  const Measurement z{predict_measurement(m.mean, T) + random_vector(random, 0.1),
                      random_covariance(random, 0.05)};
  const Innovation innovation = innovate(m, z, T);
  const Eigen::Matrix3d G = T.linear().transpose();
  const Eigen::Matrix3d S = G * m.covariance * G.transpose() + z.covariance;
  const Eigen::Vector3d v = z.value - predict_measurement(m.mean, T);
  EXPECT_NEAR(innovation.distance2, v.dot(S.inverse() * v), 1e-9);
  EXPECT_NEAR(std::exp(innovation.log_peak), 1 / std::sqrt((2 * M_PI * S).determinant()), 1e-6);
}

// Any number of measurements from any poses: the information form in one go gives the same.
TEST(LandmarkFilter, SequenceEqualsClosedForm) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
    LandmarkGaussian landmark;
    const Eigen::Vector3d truth = random_vector(random, 2);
    for (int i = 0; i < 30; ++i) {
      const Eigen::Isometry3d T = random_pose(random);
      const Measurement z{T.inverse() * truth + random_vector(random, 0.03), random_covariance(random, 0.03)};
      landmark = i == 0 ? make_landmark(z, T) : update_landmark(landmark, innovate(landmark, z, T), z, T, 0);
      const Eigen::Matrix3d W = (T.linear() * z.covariance * T.linear().transpose()).inverse();
      information += W;
      weighted += W * (T * z.value);
    }
    EXPECT_TRUE(landmark.covariance.isApprox(information.inverse(), 1e-6)) << "seed " << seed;
    EXPECT_TRUE(landmark.mean.isApprox(information.inverse() * weighted, 1e-6)) << "seed " << seed;
  }
}

TEST(LandmarkFilter, CovarianceStaysSymmetricAndPositiveForMillionUpdates) {
  Random random(2);
  Eigen::Matrix3d sharp = Eigen::Vector3d(1e-2, 1e-8, 1e-5).asDiagonal();  // very unequal axes
  Measurement z{Eigen::Vector3d(1, 2, 3), sharp};
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 64; ++i) poses.push_back(random_pose(random));
  LandmarkGaussian landmark = make_landmark(z, poses[0]);
  for (int i = 0; i < 1'000'000; ++i) {
    const Eigen::Isometry3d& T = poses[static_cast<std::size_t>(i % 64)];
    z.value = predict_measurement(landmark.mean, T);
    landmark = update_landmark(landmark, innovate(landmark, z, T), z, T, 0);
  }
  ASSERT_TRUE(landmark.covariance.allFinite());
  EXPECT_EQ(landmark.covariance, landmark.covariance.transpose().eval());
  EXPECT_GT(landmark.covariance.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0);
}

}  // namespace
}  // namespace lcmslam
