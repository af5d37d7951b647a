#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>
#include <thread>
#include <vector>

#include <lcmslam/fastslam/landmarks/node_pool.hpp>
#include <lcmslam/fastslam/landmarks/particle_map.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {
namespace {

Eigen::Vector3d random_vector(Random& random, double scale) {
  return scale * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
}

Eigen::Isometry3d random_pose(Random& random, const Eigen::Vector3d& centre) {
  Vector6d twist;
  twist << random_vector(random, 2), random_vector(random, 0.7);
  return Eigen::Translation3d(centre) * se3_exp(twist);
}

double smallest_eigenvalue(const Eigen::Matrix3d& covariance) {
  return covariance.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff();
}

TEST(CompactLandmark, IsHalfAsLarge) {
  EXPECT_EQ(sizeof(CompactLandmark), 48u);
  EXPECT_EQ(sizeof(LandmarkGaussian), 96u);
}

TEST(CompactLandmark, KeepsTheMeanExactlyAndTheCovarianceToAFloat) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed);
    const Eigen::Vector3d sigmas(std::pow(10., random.uniform(-4, 1)), std::pow(10., random.uniform(-4, 1)),
                                 std::pow(10., random.uniform(-4, 1)));  // 0.1 mm to 10 m
    const Eigen::Matrix3d R = random_pose(random, Eigen::Vector3d::Zero()).linear();
    const Eigen::Matrix3d turned = R * sigmas.cwiseAbs2().asDiagonal() * R.transpose();
    const LandmarkGaussian g{random_vector(random, 4000), 0.5 * (turned + turned.transpose())};
    const CompactLandmark stored = g;
    EXPECT_EQ(stored.mean, g.mean);
    const Eigen::Matrix3d P = stored.covariance();
    EXPECT_EQ(P, P.transpose().eval());
    EXPECT_GT(smallest_eigenvalue(P), 0) << "seed " << seed;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        EXPECT_NEAR(P(i, j), g.covariance(i, j), 5e-7 * std::sqrt(g.covariance(i, i) * g.covariance(j, j)))
            << "seed " << seed;
    EXPECT_NEAR(stored.variance(), P.trace(), 1e-12 * P.trace());
    const CompactLandmark again = LandmarkGaussian(stored);
    EXPECT_TRUE(again.covariance().isApprox(P, 5e-7)) << "seed " << seed;
  }
}

// Also where the very unequal axes of the measurements turn from update to update.
TEST(CompactLandmark, StaysSymmetricAndPositiveForMillionUpdates) {
  Random random(2);
  const Eigen::Matrix3d sharp = Eigen::Vector3d(1e-2, 1e-8, 1e-5).asDiagonal();
  Measurement z{Eigen::Vector3d(1, 2, 3), sharp};
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 64; ++i) poses.push_back(random_pose(random, Eigen::Vector3d::Zero()));
  CompactLandmark landmark = make_landmark(z, poses[0]);
  double least = smallest_eigenvalue(landmark.covariance());
  for (int i = 0; i < 1'000'000; ++i) {
    const Eigen::Isometry3d& T = poses[static_cast<std::size_t>(i % 64)];
    z.value = predict_measurement(landmark.mean, T);
    const LandmarkGaussian now = landmark;
    landmark = update_landmark(now, innovate(now, z, T), z, T, 0);
    if (i % 1000 < 3) least = std::min(least, smallest_eigenvalue(landmark.covariance()));
  }
  const Eigen::Matrix3d P = landmark.covariance();
  ASSERT_TRUE(P.allFinite());
  EXPECT_EQ(P, P.transpose().eval());
  EXPECT_GT(least, 0);
  EXPECT_GT(smallest_eigenvalue(P), 0);
}

// Ten thousand observations of a landmark 4 km from the origin: mean and covariance are those of a filter in
// doubles.
TEST(CompactLandmark, FiltersAsDoublesDoFarFromTheOrigin) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const Eigen::Vector3d truth(4000, -3000, 20);
    CompactLandmark stored;
    LandmarkGaussian exact;
    for (int i = 0; i < 10'000; ++i) {
      const Eigen::Isometry3d T = random_pose(random, truth);
      Measurement z;  // along the ray ten times as uncertain as across it
      z.covariance.diagonal() << 0.03 * 0.03, 0.003 * 0.003, 0.003 * 0.003;
      z.value = T.inverse() * truth;
      for (int k = 0; k < 3; ++k) z.value(k) += random.normal(0, std::sqrt(z.covariance(k, k)));
      if (i == 0) {
        exact = make_landmark(z, T);
        stored = exact;
        continue;
      }
      const LandmarkGaussian now = stored;
      stored = update_landmark(now, innovate(now, z, T), z, T, 1e-10);
      exact = update_landmark(exact, innovate(exact, z, T), z, T, 1e-10);
    }
    EXPECT_LT((stored.mean - exact.mean).norm(), 1e-7) << "seed " << seed;
    EXPECT_LT((stored.covariance() - exact.covariance).norm(), 1e-4 * exact.covariance.norm())
        << "seed " << seed;
    EXPECT_LT((stored.mean - truth).norm(), 5 * std::sqrt(exact.covariance.trace())) << "seed " << seed;
  }
}

TEST(NodePool, GivesEachNodeToOneOwnerOfAnyThread) {
  using Pool = NodePool<48>;
  constexpr std::size_t count = 1000;
  std::vector<std::vector<void*>> taken(4, std::vector<void*>(count));
  for (int round = 0; round < 5; ++round) {
    std::vector<std::thread> threads;
    for (auto& nodes : taken)
      threads.emplace_back([&nodes] {
        for (void*& node : nodes) node = Pool::take();
      });
    for (std::thread& thread : threads) thread.join();
    std::set<void*> distinct;
    for (const auto& nodes : taken) distinct.insert(nodes.begin(), nodes.end());
    ASSERT_EQ(distinct.size(), taken.size() * count);
    for (const auto& nodes : taken)  // all by this thread: they must come back to the others
      for (void* node : nodes) Pool::give_back(node);
  }
}

#ifndef LCMSLAM_NO_NODE_POOL
TEST(NodePool, UsesAgainWhatWasGivenBack) {
  using Pool = NodePool<80>;
  std::vector<void*> nodes(1000);
  std::set<void*> seen;
  for (int round = 0; round < 100; ++round) {
    std::thread([&] {
      for (void*& node : nodes) node = Pool::take();
    }).join();
    seen.insert(nodes.begin(), nodes.end());
    for (void* node : nodes) Pool::give_back(node);
  }
  EXPECT_LT(seen.size(), 2 * nodes.size()) << "though one thread takes and another gives back";
}
#endif

}  // namespace
}  // namespace lcmslam
