// Algorithm 3.2 of the thesis: clouds and SURF points by turns.

#include <lcmslam/dense_mapper/thesis/alternating.hpp>

#include <gtest/gtest.h>

#include <lcmslam/registration/kd_tree_target.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

/// A room, the same room moved far, and some noisy corresponding points on it.
struct FarPair {
  Cloud source, target = room();
  FeaturePairs features;
  Eigen::Isometry3d T_target_source;

  explicit FarPair(std::uint64_t seed, int count = 15, double sigma = 0.02) {
    Random random(seed);
    T_target_source = se3_exp(twist(0.8, -0.6, 0.2, 0.3, -0.2, 2.0));
    source = transformed(room(0.061), T_target_source.inverse());  // other points of the same surfaces
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(random.uniform() * static_cast<double>(target.size()));
      const auto noise = [&]() -> Eigen::Vector3d {
        return Eigen::Vector3d(random.normal(), random.normal(), random.normal()) * sigma;
      };
      const Eigen::Vector3d p = target.points[k].cast<double>();
      features.target.push_back((p + noise()).cast<float>());
      features.source.push_back((T_target_source.inverse() * (p + noise())).cast<float>());
    }
  }
};

double error(const Eigen::Isometry3d& T, const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d difference = truth.inverse() * T;
  return difference.translation().norm() + 2 * rotation_angle(difference);  // the room is 2 m away
}

TEST(Alternating, ConvergesWhereTheCloudAloneDoesNot) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
    const FarPair pair(seed);
    const KdTreeTarget target(pair.target);
    AlternatingSettings settings;
    settings.pairing = FeaturePairing::fixed;
    RegistrationSettings alone = settings.registration;
    alone.max_iterations = 200;
    const auto raw = register_cloud(pair.source, target, Eigen::Isometry3d::Identity(), alone);
    EXPECT_GT(error(raw.T_target_source, pair.T_target_source), 0.1) << "the case is hard";

    const auto result =
        register_alternating(pair.source, target, pair.features, Eigen::Isometry3d::Identity(), settings);
    EXPECT_TRUE(result.ok()) << to_string(result.stop);
    EXPECT_LT(error(result.T_target_source, pair.T_target_source), 0.05) << seed;
    EXPECT_EQ(result.cloud_rms.size(), result.feature_rms.size());
  }
}

TEST(Alternating, StartFromTheFeaturesAndNearestPairsGoOnFromThere) {
  for (const auto solver : {SolverKind::svd, SolverKind::quaternion}) {
    const FarPair pair(7);
    const KdTreeTarget target(pair.target);
    AlternatingSettings settings;
    settings.registration.solver = solver;
    const auto start = align_start(pair.features, settings.registration);
    ASSERT_TRUE(start);
    EXPECT_LT(error(*start, pair.T_target_source), 0.15);
    const auto result = register_alternating(pair.source, target, pair.features, *start, settings);
    EXPECT_TRUE(result.ok());
    EXPECT_LT(error(result.T_target_source, pair.T_target_source), 0.05);
  }
}

TEST(Alternating, TheSmallerErrorIsTaken) {
  const FarPair noisy(3, 15, 0.05), exact(3, 15, 0);
  for (const FarPair* pair : {&noisy, &exact}) {
    const KdTreeTarget target(pair->target);
    AlternatingSettings settings;
    settings.pairing = FeaturePairing::fixed;
    const auto result =
        register_alternating(pair->source, target, pair->features, pair->T_target_source, settings);
    EXPECT_EQ(result.from_features, pair == &exact);
    EXPECT_EQ(result.from_features, result.feature_rms.back() < result.cloud_rms.back());
  }
}

TEST(Alternating, OneSetAloneGoesOn) {
  const FarPair pair(1);
  const KdTreeTarget target(pair.target);
  const KdTreeTarget nothing(Cloud{});
  AlternatingSettings settings;
  const auto cloud_only = register_alternating(pair.source, target, {}, pair.T_target_source, settings);
  EXPECT_TRUE(cloud_only.ok());
  EXPECT_FALSE(cloud_only.from_features);
  EXPECT_LT(error(cloud_only.T_target_source, pair.T_target_source), 0.05);
  settings.pairing = FeaturePairing::fixed;
  const auto features_only = register_alternating({}, nothing, pair.features, pair.T_target_source, settings);
  EXPECT_TRUE(features_only.ok());
  EXPECT_TRUE(features_only.from_features);
  const auto neither = register_alternating({}, nothing, {}, pair.T_target_source, settings);
  EXPECT_EQ(neither.stop, StopReason::too_few_pairs);
  EXPECT_TRUE(neither.T_target_source.matrix().allFinite());
}

TEST(Alternating, RefusesWhatMakesNoSense) {
  const KdTreeTarget target(room());
  FeaturePairs uneven;
  uneven.source.emplace_back(0, 0, 0);
  EXPECT_THROW(register_alternating(room(), target, uneven, Eigen::Isometry3d::Identity()),
               std::invalid_argument);
  AlternatingSettings settings;
  settings.cloud_iterations = settings.feature_iterations = 0;
  EXPECT_THROW(register_alternating(room(), target, {}, Eigen::Isometry3d::Identity(), settings),
               std::invalid_argument);
  settings = {};
  settings.registration.metric = MetricKind::point_to_plane;
  EXPECT_THROW(register_alternating(room(), target, {}, Eigen::Isometry3d::Identity(), settings),
               std::invalid_argument);
  EXPECT_FALSE(align_start({}, AlternatingSettings().registration));
}

// The linear estimator, too, gives the pairs' least squares, however far the clouds are turned.
TEST(AlignStart, SmallAnglesGoOnUntilTheyStandStill) {
  Random random(5);
  const Eigen::Isometry3d T = se3_exp((Vector6d() << 0.4, -0.3, 0.2, 0.1, -0.2, 0.8).finished());
  FeaturePairs pairs;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(1, 3));
    pairs.source.push_back(p.cast<float>());
    pairs.target.push_back((T * p).cast<float>());
  }
  for (const SolverKind solver : {SolverKind::svd, SolverKind::quaternion, SolverKind::small_angle}) {
    RegistrationSettings settings = AlternatingSettings().registration;
    settings.solver = solver;
    const auto start = align_start(pairs, settings);
    ASSERT_TRUE(start);
    EXPECT_LT(distance_between(*start, T), 1e-5) << static_cast<int>(solver);
    EXPECT_LT(angle_between(*start, T), 1e-5) << static_cast<int>(solver);
  }
}

}  // namespace
}  // namespace lcmslam
