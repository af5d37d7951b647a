// Slips, and a lost robot.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/fastslam/association/frame_association.hpp>
#include <lcmslam/fastslam/association/visibility.hpp>
#include "tests/unit/fastslam/association_scene.hpp"

namespace lcmslam {
namespace {

using Scene = AssociationScene;

using synthetic::WorldSettings;

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

/// Its landmarks are well known, and were seen from here, or from `aside` of it.
struct KnownScene : Scene {
  explicit KnownScene(std::uint64_t seed, double aside = 0.1) : Scene(seed) {
    const Eigen::Vector3d camera =
        T_world_robot * frame.T_robot_camera.translation() + Eigen::Vector3d(aside, 0, 0);
    for (int slot = 0; slot < index.slots(); ++slot) {
      LandmarkRecord& record = index.record(slot);
      const Eigen::Vector3d ray = camera - map.find(static_cast<std::size_t>(slot))->mean;
      record.observations = 50;
      record.seen_from = ray.normalized();
      record.seen_at = ray.norm();
    }
  }

  void show_strange_things() {
    Random random(7);
    for (Feature& feature : frame.features)
      for (auto& byte : feature.descriptor) byte = static_cast<std::uint8_t>(random.below(200));
  }

  FrameAssociation associate() const {
    Motion prior;
    prior.covariance.diagonal().setConstant(1e-4);
    return FrameAssociator(settings).associate(frame, usable_features(frame, settings), T_world_robot, prior,
                                               map, index);
  }
};

// A wall that was never looked at hides a room that is known well.
TEST(FrameAssociation, WhatWasSeenFromElsewhereContradictsNothing) {
  for (const bool from_here : {true, false}) {
    KnownScene scene(2, from_here ? 0.1 : 3);
    scene.show_strange_things();
    EXPECT_EQ(scene.associate().contradicted, from_here);
  }
}

// Few features have depth and agree on no pose; many others lie where the prediction has them.
TEST(FrameAssociation, FeaturesWithoutDepthConfirmThePrediction) {
  for (const bool strange : {false, true}) {
    KnownScene scene(2);
    if (strange) scene.show_strange_things();
    std::size_t n = 0;
    for (Feature& feature : scene.frame.features)
      if (n++ % 12 != 0) feature.kind = MeasurementKind::bearing;
    const FrameAssociation result = scene.associate();
    EXPECT_FALSE(result.agreed);
    EXPECT_EQ(result.confirmed, !strange);
    EXPECT_FALSE(result.contradicted);
  }
}

// A door, a trolley, somebody in a patterned coat.
TEST(FrameAssociation, WhatStandsBeforeTheCameraHidesWhatIsKnown) {
  for (const double distance : {1.0, 0.4}) {
    KnownScene scene(2);
    scene.show_strange_things();
    for (Feature& feature : scene.frame.features) feature.point *= static_cast<float>(distance);
    const FrameAssociation result = scene.associate();
    EXPECT_FALSE(result.agreed) << distance;
    EXPECT_TRUE(result.contradicted) << distance;
    EXPECT_EQ(result.hidden, distance < 1) << distance;
  }
}

// Beyond the border nothing is measured: what stands close at the border hides what is in the image.
TEST(LandmarkVisibility, NothingIsKnownBeyondTheImage) {
  FeatureFrame frame;
  frame.width = 640;
  frame.height = 480;
  Feature feature;
  feature.x = 630;
  feature.y = 240;
  frame.features = {feature};
  FeaturePoint close;
  close.range = 1;
  const LandmarkVisibility visibility(frame, {close}, Eigen::Isometry3d::Identity());
  const auto landmark_at = [](double x) { return VisibleLandmark{0, x, 240, 2, Eigen::Vector3d::Zero()}; };
  EXPECT_TRUE(visibility.is_hidden(landmark_at(625)));
  EXPECT_FALSE(visibility.is_hidden(landmark_at(660)));
}

}  // namespace
}  // namespace lcmslam
