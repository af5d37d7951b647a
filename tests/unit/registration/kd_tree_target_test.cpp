#include <lcmslam/registration/kd_tree_target.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

TEST(NormalShooting, TakesTheCandidateAlongTheNormal) {
  Cloud cloud;
  cloud.points = {{0.1f, 0, 0}, {0, 0, 0.2f}};
  const NormalShootingTarget target(cloud);
  TargetPoint found;
  ASSERT_TRUE(target.find({0, 0, 0}, 1, found));
  EXPECT_EQ(found.point.x(), 0.1f);
  ASSERT_TRUE(target.find_along({0, 0, 0}, {0, 0, -1}, 1, found));
  EXPECT_EQ(found.point.z(), 0.2f);
  ASSERT_TRUE(target.find_along({0, 0, 0}, {0, 0, -1}, 0.15f, found));  // the other one is too far
  EXPECT_EQ(found.point.x(), 0.1f);
  ASSERT_TRUE(target.find_along({0, 0, 0}, Eigen::Vector3f::Constant(NAN), 1, found));
  EXPECT_EQ(found.point.x(), 0.1f);
  EXPECT_FALSE(target.find_along({0, 0, 0}, {0, 0, 1}, 0.05f, found));
}

}  // namespace
}  // namespace lcmslam
