// The pose on which most matches agree.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/fastslam/association/consensus.hpp>
#include "tests/unit/fastslam/association_scene.hpp"

namespace lcmslam {
namespace {

TEST(Consensus, FindsThePoseAmongWrongMatches) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    for (const bool planar : {true, false}) {
      Random random(seed);
      Eigen::Isometry3d T = planar_pose(random.normal(), random.normal(), random.normal());
      if (!planar) T = T * se3_exp((Vector6d() << 0, 0, 0.2, 0.2, -0.3, 0).finished());
      std::vector<ObservedLandmark> pairs;
      for (int i = 0; i < 60; ++i) {
        ObservedLandmark pair;
        pair.measurement.value << random.uniform(1, 5), random.uniform(-2, 2), random.uniform(0, 2);
        pair.measurement.covariance = pair.landmark.covariance = 1e-4 * Eigen::Matrix3d::Identity();
        const double sigma = 0.014;
        pair.landmark.mean = T * (pair.measurement.value +
                                  sigma * Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
        if (i % 5 < 2)
          pair.landmark.mean += Eigen::Vector3d(random.normal(), random.normal(), random.normal());
        pairs.push_back(pair);
      }
      const auto found = find_consensus(pairs, Eigen::Isometry3d::Identity(), planar, 8, random);
      ASSERT_TRUE(found) << "seed " << seed << " planar " << planar;
      EXPECT_GE(found->inliers, 33) << "seed " << seed;
      EXPECT_LE(found->inliers, 39) << "seed " << seed;
      EXPECT_LT((found->T_world_robot.translation() - T.translation()).norm(), 0.03) << "seed " << seed;
      EXPECT_LT(rotation_angle(found->T_world_robot.inverse() * T), 0.01) << "seed " << seed;
    }
}

TEST(Consensus, NothingWhereNothingAgrees) {
  Random random(1);
  std::vector<ObservedLandmark> pairs(30);
  for (auto& pair : pairs) {
    pair.measurement.value << random.uniform(1, 5), random.uniform(-2, 2), random.uniform(0, 2);
    pair.landmark.mean << random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5);
    pair.measurement.covariance = pair.landmark.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  }
  EXPECT_FALSE(find_consensus(pairs, Eigen::Isometry3d::Identity(), true, 8, random));
  pairs.resize(3);
  EXPECT_FALSE(find_consensus(pairs, Eigen::Isometry3d::Identity(), true, 8, random));
  for (auto& pair : pairs) pair = pairs[0];  // one point: no pose
  EXPECT_FALSE(find_consensus(pairs, Eigen::Isometry3d::Identity(), true, 3, random));
}

}  // namespace
}  // namespace lcmslam
