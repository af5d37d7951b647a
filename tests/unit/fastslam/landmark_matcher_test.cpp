// Which feature shows which landmark, by descriptors where each should be.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/fastslam/association/landmark_matcher.hpp>
#include "tests/unit/fastslam/association_scene.hpp"

namespace lcmslam {
namespace {

using Scene = AssociationScene;

using synthetic::WorldSettings;

TEST(LandmarkMatcher, MatchesVisibleLandmarksRightly) {
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

TEST(LandmarkMatcher, RivalAtTheSamePlaceIsNoRival) {
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

// The larger the map, the more strangers look alike; places keep them apart.
TEST(LandmarkMatcher, GatesKeepTheRatioTestMeaningful) {
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

// A heading that may err moves what a camera sees sideways, however the camera looks at the world.
TEST(LandmarkMatcher, GatesReachAsFarAsTheRobotsHeadingMayErr) {
  constexpr double error = 0.05;  // rad
  Scene scene(3);
  const auto usable = usable_features(scene.frame, scene.settings);
  const Eigen::Isometry3d T_predicted =
      scene.T_world_robot * Eigen::AngleAxisd(error, Eigen::Vector3d::UnitZ());
  Matrix6d Q = 1e-8 * Matrix6d::Identity();
  Q(5, 5) = error * error;
  LandmarkMatcher matcher;
  matcher.begin(scene.frame, usable);
  const auto visible = visible_landmarks(scene.map, scene.index, T_predicted, scene.frame, scene.settings);
  const auto matches = matcher.guided(visible, scene.map, scene.index, T_predicted, Q, scene.settings);
  const auto known = std::count_if(scene.truth.begin(), scene.truth.end(), [](int t) { return t >= 0; });
  EXPECT_GT(scene.right(usable, matches), 0.5 * static_cast<double>(known));
}

}  // namespace
}  // namespace lcmslam
