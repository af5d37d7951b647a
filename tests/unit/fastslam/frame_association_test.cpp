// Slips, and a lost robot.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/fastslam/association/frame_association.hpp>
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

}  // namespace
}  // namespace lcmslam
