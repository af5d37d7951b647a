// What goes with a robot that drives, told by its view and its wheels alone.

#include <gtest/gtest.h>

#include <lcmslam/dense_mapper/companion.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {
namespace {

/// A board across the way, x m ahead of the robot.
void add_board(Cloud& cloud, float x, float width) {
  for (float y = -width / 2; y < width / 2; y += 0.03f)
    for (float z = 0.1f; z < 1.5f; z += 0.03f) {
      cloud.points.emplace_back(x, y, z);
      cloud.normals.emplace_back(-Eigen::Vector3f::UnitX());
      cloud.sigmas.push_back(0.003f);
    }
}

/// A wall 4 m ahead of where the robot was, which has driven `way` m, and a board 1.2 m before it.
Cloud view_after(double way, float board_width) {
  Cloud cloud;
  add_board(cloud, static_cast<float>(4 - way), 3);
  if (board_width > 0) add_board(cloud, 1.2f, board_width);
  return cloud;
}

Motion driven(double step) {
  Motion motion;
  motion.T_from_to = planar_pose(step, 0, 0);
  return motion;
}

TEST(Companion, GoesOnUntilItLeaves) {
  Companion companion;
  EXPECT_FALSE(companion.there());
  companion.begin(view_after(0, 1));
  for (int i = 1; i <= 40; ++i) {
    companion.observe(view_after(0.04 * i, 1), driven(0.04));
    ASSERT_TRUE(companion.there()) << i;
  }
  companion.observe(view_after(0.04 * 41, 0), driven(0.04));
  EXPECT_FALSE(companion.there());
}

TEST(Companion, WasNoneWhereTheViewPasses) {
  Companion companion;
  companion.begin(view_after(0, 0));
  companion.observe(view_after(0.04, 0), driven(0.04));
  EXPECT_FALSE(companion.there());
}

TEST(Companion, IsLikeWheelsThatSpin) {
  Companion companion;
  companion.begin(view_after(0, 0));
  for (int i = 0; i < 20; ++i) companion.observe(view_after(0, 0), driven(0.04));
  EXPECT_TRUE(companion.there());
  // They grip again: as soon as what it saw then passes.
  for (int i = 1; i < 20; ++i) companion.observe(view_after(0.04 * i, 0), driven(0.04));
  EXPECT_FALSE(companion.there());
}

TEST(Companion, StaysWhileNothingTells) {
  Companion companion;
  companion.begin(view_after(0, 1));
  companion.observe(view_after(0, 0), driven(0));  // the board has gone; where wheels stand nothing passes
  companion.observe({}, driven(0.04));
  EXPECT_TRUE(companion.there());
}

}  // namespace
}  // namespace lcmslam
