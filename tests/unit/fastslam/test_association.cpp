#include <gtest/gtest.h>

#include <algorithm>

#include "fastslam/consensus.hpp"
#include "fastslam/frame_association.hpp"
#include "unit/fastslam/synthetic_world.hpp"

namespace lcmslam {
namespace {

using synthetic::WorldSettings;

// A map made from a world's true points, and what the robot sees from one pose.
struct Scene {
  FastSlamSettings settings;
  std::vector<synthetic::Point> points;
  ParticleMap map;
  LandmarkIndex index;
  FeatureFrame frame;
  std::vector<int> truth;  // slot of each feature
  Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();

  explicit Scene(std::uint64_t seed, WorldSettings world = {}) {
    Random random(seed);
    points = synthetic::make_points(world, random);
    for (std::size_t i = 0; i < points.size(); ++i) {
      Feature f;
      f.descriptor = synthetic::noisy_bytes(points[i].descriptor, 0, random);
      f.laplacian = points[i].laplacian;
      map.edit(static_cast<std::size_t>(index.add(f, settings))) = {points[i].position,
                                                                    1e-4 * Eigen::Matrix3d::Identity()};
    }
    T_world_robot = synthetic::true_pose(world, static_cast<int>(random.below(400)));
    frame = synthetic::see(world, points, T_world_robot, random, truth);
  }

  int right(const std::vector<FeaturePoint>& usable, const std::vector<LandmarkMatch>& matches) const {
    return static_cast<int>(std::count_if(matches.begin(), matches.end(), [&](const LandmarkMatch& m) {
      const int feature = usable[static_cast<std::size_t>(m.point)].feature;
      return truth[static_cast<std::size_t>(feature)] == m.slot;
    }));
  }
};

TEST(Association, MatchesVisibleLandmarksRightly) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    Scene scene(seed);
    const auto usable = usable_features(scene.frame, scene.settings);
    const auto visible =
        visible_landmarks(scene.map, scene.index, scene.T_world_robot, scene.frame, scene.settings);
    const auto matches = match_visible(scene.frame, usable, visible, scene.index, 96, scene.settings);
    const auto known = std::count_if(scene.truth.begin(), scene.truth.end(), [](int t) { return t >= 0; });
    EXPECT_GE(scene.right(usable, matches), 0.9 * static_cast<double>(known));
    EXPECT_LE(static_cast<int>(matches.size()) - scene.right(usable, matches), 2);
    EXPECT_TRUE(std::is_sorted(matches.begin(), matches.end(),
                               [](const auto& a, const auto& b) { return a.slot < b.slot; }));
  }
}

TEST(Association, RivalAtTheSamePlaceIsNoRival) {
  Scene scene(3);
  const auto usable = usable_features(scene.frame, scene.settings);
  const auto count = [&] {
    const auto visible =
        visible_landmarks(scene.map, scene.index, scene.T_world_robot, scene.frame, scene.settings);
    return match_visible(scene.frame, usable, visible, scene.index, 96, scene.settings).size();
  };
  const std::size_t before = count();
  const auto duplicate_all = [&](double offset) {
    Random random(1);
    for (std::size_t i = 0; i < scene.points.size(); ++i) {
      Feature f;
      f.descriptor = synthetic::noisy_bytes(scene.points[i].descriptor, 0.05, random);
      f.laplacian = scene.points[i].laplacian;
      const Eigen::Vector3d mean = scene.points[i].position + Eigen::Vector3d(0, 0, offset);
      scene.map.edit(static_cast<std::size_t>(scene.index.add(f, scene.settings))) = {
          mean, 1e-4 * Eigen::Matrix3d::Identity()};
    }
  };
  duplicate_all(0.02);
  EXPECT_GE(count(), before * 9 / 10);
  duplicate_all(0.3);  // a true repetition 30 cm away: ambiguous
  EXPECT_LT(count(), before / 3);
}

TEST(Association, UnusableFeaturesAreLeftOut) {
  Scene scene(1);
  const std::size_t before = usable_features(scene.frame, scene.settings).size();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  scene.frame.features[0].point.x() = nan;
  scene.frame.features[1].depth_sigma = nan;
  scene.frame.features[2].kind = MeasurementKind::bearing;
  scene.frame.features[3].depth_sigma = -1;
  scene.frame.features[4].point *= 100.f;
  scene.frame.features[5].point.z() *= -1;
  scene.frame.features[6].x = std::numeric_limits<float>::infinity();
  const auto usable = usable_features(scene.frame, scene.settings);
  EXPECT_EQ(usable.size(), before - 7);
  for (const FeaturePoint& point : usable) EXPECT_GT(point.feature, 6);
  scene.frame.fx = 0;
  EXPECT_TRUE(usable_features(scene.frame, scene.settings).empty());
}

TEST(Association, SelectionIsSpreadAndKeepsTheBestKnown) {
  Scene scene(2);
  const auto usable = usable_features(scene.frame, scene.settings);
  const auto visible =
      visible_landmarks(scene.map, scene.index, scene.T_world_robot, scene.frame, scene.settings);
  const auto matches = match_visible(scene.frame, usable, visible, scene.index, 96, scene.settings);
  ASSERT_GT(matches.size(), 30u);
  scene.settings.maximum_observations = 20;
  const auto selected = select_informative(matches, scene.frame, usable, scene.map, scene.settings);
  ASSERT_EQ(selected.size(), 20u);
  std::vector<double> x;
  for (const auto& m : selected)
    x.push_back(
        scene.frame.features[static_cast<std::size_t>(usable[static_cast<std::size_t>(m.point)].feature)].x);
  EXPECT_LT(*std::min_element(x.begin(), x.end()), 200);
  EXPECT_GT(*std::max_element(x.begin(), x.end()), 440);
}

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

TEST(FrameAssociation, NoticesSlipsAndCorrectsTheMotion) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    Scene scene(seed);
    FrameAssociator associator(scene.settings);
    const auto usable = usable_features(scene.frame, scene.settings);
    Motion prior;
    prior.covariance.diagonal().head<3>().setConstant(0.005 * 0.005);
    prior.covariance.diagonal().tail<3>().setConstant(0.005 * 0.005);
    const Eigen::Isometry3d T_slip = planar_pose(0.04, 0.03, 0.05);  // 5 cm, 3 degrees
    const auto honest =
        associator.associate(scene.frame, usable, scene.T_world_robot, prior, scene.map, scene.index);
    EXPECT_FALSE(honest.slipped);
    EXPECT_TRUE(honest.agreed);
    const auto slipped = associator.associate(scene.frame, usable, scene.T_world_robot * T_slip.inverse(),
                                              prior, scene.map, scene.index);
    EXPECT_TRUE(slipped.slipped);
    EXPECT_LT((slipped.prior.T_from_to.translation() - T_slip.translation()).norm(), 0.02);
    EXPECT_LT(rotation_angle(slipped.prior.T_from_to.inverse() * T_slip), 0.01);
    EXPECT_GT(slipped.matches.size(), 0.8 * static_cast<double>(honest.matches.size()));
  }
}

TEST(FrameAssociation, FindsALostRobotInTheWholeMap) {
  WorldSettings world;
  world.landmarks = 4000;
  Scene scene(4, world);
  FrameAssociator associator(scene.settings);
  const auto usable = usable_features(scene.frame, scene.settings);
  Motion prior;
  prior.covariance.diagonal().setConstant(1e-4);
  const Eigen::Isometry3d T_wrong = scene.T_world_robot * planar_pose(0.3, 0.2, 2.5);
  for (int i = 0; i < scene.settings.relocalise_after; ++i)
    EXPECT_FALSE(
        associator.associate(scene.frame, usable, T_wrong, prior, scene.map, scene.index).T_world_found);
  const auto found = associator.associate(scene.frame, usable, T_wrong, prior, scene.map, scene.index);
  ASSERT_TRUE(found.T_world_found);
  EXPECT_LT((found.T_world_found->translation() - scene.T_world_robot.translation()).norm(), 0.03);
  EXPECT_EQ(associator.steps_without_agreement(), 0);
}

}  // namespace
}  // namespace lcmslam
