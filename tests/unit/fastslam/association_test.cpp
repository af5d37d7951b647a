#include <gtest/gtest.h>

#include <algorithm>

#include <lcmslam/fastslam/association/consensus.hpp>
#include <lcmslam/fastslam/association/frame_association.hpp>
#include "tests/unit/fastslam/synthetic_world.hpp"

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

  // Sought within three sigma of 96 pixels.
  std::vector<LandmarkMatch> match(const std::vector<FeaturePoint>& usable) const {
    Matrix6d Q = Matrix6d::Zero();
    Q.diagonal().tail<3>().setConstant(std::pow(96 / (3 * frame.fx), 2));
    LandmarkMatcher matcher;
    matcher.begin(frame, usable);
    return matcher.guided(visible_landmarks(map, index, T_world_robot, frame, settings), map, index,
                          T_world_robot, Q, settings);
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
    const auto matches = scene.match(usable);
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
  const auto count = [&] { return scene.match(usable).size(); };
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
  scene.settings.use_bearings = false;
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

TEST(Association, PlanarMeasurementsNeedASigmaAndAnIdentity) {
  FeatureFrame frame;
  frame.width = frame.height = 1;
  frame.fx = frame.fy = 1;
  frame.pixel_sigma = 0.02f;
  Feature sound;
  sound.kind = MeasurementKind::range_bearing;
  sound.landmark_id = 3;
  sound.point = {2, 0.5f, 0};
  sound.depth_sigma = 0.1f;
  const float inf = std::numeric_limits<float>::infinity();
  for (const MeasurementKind kind : {MeasurementKind::range_bearing, MeasurementKind::planar}) {
    sound.kind = kind;
    frame.features.assign(8, sound);
    frame.features[1].depth_sigma = inf;
    frame.features[2].depth_sigma = std::numeric_limits<float>::quiet_NaN();
    frame.features[3].depth_sigma = 0;
    frame.features[4].point.x() = inf;
    frame.features[5].point.y() = std::numeric_limits<float>::quiet_NaN();
    frame.features[6].point.x() = 1e30f;
    frame.features[7].landmark_id = -1;
    const auto usable = usable_features(frame, {});
    ASSERT_EQ(usable.size(), 1u);
    EXPECT_EQ(usable[0].feature, 0);
  }
}

// The cells of the grid and the view's planes leave nothing out.
TEST(Association, VisibleLandmarksAreThoseInTheImage) {
  std::size_t total = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const Scene scene(seed);
    const double margin = scene.settings.visibility_margin * scene.frame.width;
    std::vector<int> expected, found;
    const Eigen::Isometry3d T_camera_world = (scene.T_world_robot * scene.frame.T_robot_camera).inverse();
    for (int slot = 0; slot < scene.index.slots(); ++slot) {
      const Eigen::Vector3d p = T_camera_world * scene.map.find(static_cast<std::size_t>(slot))->mean;
      if (p.z() < 0.5 * scene.settings.minimum_range || p.norm() > 1.1 * scene.settings.maximum_range)
        continue;
      const double x = scene.frame.fx * p.x() / p.z() + scene.frame.cx;
      const double y = scene.frame.fy * p.y() / p.z() + scene.frame.cy;
      const bool inside =
          x >= -margin && x <= scene.frame.width + margin && y >= -margin && y <= scene.frame.height + margin;
      if (inside) expected.push_back(slot);
    }
    for (const VisibleLandmark& v :
         visible_landmarks(scene.map, scene.index, scene.T_world_robot, scene.frame, scene.settings))
      found.push_back(v.slot);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
    total += found.size();
  }
  EXPECT_GT(total, 500u);
}

TEST(Association, FeaturesWithoutDepthAreBearings) {
  Scene scene(1);
  const auto points = usable_features(scene.frame, scene.settings);
  for (std::size_t i = 0; i < scene.frame.features.size(); i += 2) {
    scene.frame.features[i].kind = MeasurementKind::bearing;
    scene.frame.features[i].point.setConstant(std::numeric_limits<float>::quiet_NaN());
    scene.frame.features[i].depth_sigma = std::numeric_limits<float>::quiet_NaN();
  }
  const auto usable = usable_features(scene.frame, scene.settings);
  EXPECT_EQ(usable.size(), points.size()) << "in range, all of them";
  int bearings = 0, right = 0;
  for (const FeaturePoint& p : usable) {
    const Feature& f = scene.frame.features[static_cast<std::size_t>(p.feature)];
    EXPECT_EQ(p.is_bearing(), f.kind == MeasurementKind::bearing);
    bearings += p.is_bearing();
    const int slot = scene.truth[static_cast<std::size_t>(p.feature)];
    if (!p.is_bearing() || slot < 0) continue;
    const LandmarkGaussian& landmark = *scene.map.find(static_cast<std::size_t>(slot));
    right += innovate(landmark, p.measurement, scene.T_world_robot).distance2 < 13.8;  // chi-square, 99.9 %
  }
  EXPECT_NEAR(bearings, static_cast<double>(usable.size()) / 2, 1);
  EXPECT_GT(right, 0.75 * bearings) << "the others show other landmarks, or none";
  const auto matches = scene.match(usable);
  const auto of_bearings = std::count_if(matches.begin(), matches.end(), [&](const LandmarkMatch& m) {
    return usable[static_cast<std::size_t>(m.point)].is_bearing();
  });
  EXPECT_GT(of_bearings, 0.6 * bearings);
  EXPECT_LE(static_cast<int>(matches.size()) - scene.right(usable, matches), 2);
}

// The larger the map, the more strangers look alike; places keep them apart.
TEST(Association, GatesKeepTheRatioTestMeaningful) {
  WorldSettings world;
  world.landmarks = 12'000;
  Scene scene(5, world);
  Random random(5);
  std::vector<std::array<double, 64>> kinds,
      own;  // of things; a landmark differs little from others of its kind
  for (int i = 0; i < 600; ++i) kinds.push_back(synthetic::random_descriptor(random));
  scene.index = LandmarkIndex();
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    own.push_back(synthetic::random_descriptor(random));
    for (std::size_t k = 0; k < 64; ++k) own[i][k] = 0.998 * kinds[i % kinds.size()][k] + 0.06 * own[i][k];
    Feature f;
    f.descriptor = synthetic::noisy_bytes(own[i], 0, random);
    f.laplacian = scene.points[i].laplacian;
    scene.index.add(f, scene.settings);
  }
  for (std::size_t i = 0; i < scene.truth.size(); ++i)
    if (scene.truth[i] >= 0)
      scene.frame.features[i].descriptor =
          synthetic::noisy_bytes(own[static_cast<std::size_t>(scene.truth[i])], 0.15, random);
  const auto usable = usable_features(scene.frame, scene.settings);
  const auto visible =
      visible_landmarks(scene.map, scene.index, scene.T_world_robot, scene.frame, scene.settings);
  LandmarkMatcher matcher;
  matcher.begin(scene.frame, usable);
  const auto everywhere = matcher.everywhere(scene.map, scene.index, scene.settings);
  const auto among = matcher.among(visible, scene.map, scene.index, scene.settings);
  Matrix6d Q = Matrix6d::Zero();
  Q.diagonal().head<3>().setConstant(1e-5);
  Q.diagonal().tail<3>().setConstant(1e-5);
  const auto guided = matcher.guided(visible, scene.map, scene.index, scene.T_world_robot, Q, scene.settings);
  EXPECT_TRUE(matcher.supported());
  RecordProperty("right_everywhere", scene.right(usable, everywhere));
  RecordProperty("right_among", scene.right(usable, among));
  RecordProperty("right_guided", scene.right(usable, guided));
  EXPECT_GT(scene.right(usable, among), scene.right(usable, everywhere));
  EXPECT_GT(scene.right(usable, guided), 1.5 * scene.right(usable, among));
  EXPECT_LT(static_cast<int>(guided.size()) - scene.right(usable, guided),
            0.02 * static_cast<double>(guided.size()) + 2);
}

TEST(Association, SelectionIsSpreadAndKeepsTheBestKnown) {
  Scene scene(2);
  const auto usable = usable_features(scene.frame, scene.settings);
  const auto matches = scene.match(usable);
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
