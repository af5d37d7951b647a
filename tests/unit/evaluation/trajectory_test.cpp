#include <lcmslam/evaluation/trajectory.hpp>

#include <gtest/gtest.h>

#include "tests/unit/evaluation/path_samples.hpp"

namespace lcmslam {
namespace {

TEST(Trajectory, OtherFrameOfTheBodyAndBack) {
  Random random(1);
  const Eigen::Isometry3d T_body_other = testing::random_pose(random);
  const Trajectory body = testing::curved_path(40);
  const Trajectory other = in_other_frame(body, T_body_other);
  const Eigen::Vector3d point(1, 2, 3);  // seen from `other`
  for (std::size_t i = 0; i < body.size(); ++i) {
    EXPECT_TRUE(
        (other[i].T_world_body * point).isApprox(body[i].T_world_body * (T_body_other * point), 1e-12));
  }
  const Trajectory back = in_other_frame(other, T_body_other.inverse());
  EXPECT_TRUE(back.back().T_world_body.isApprox(body.back().T_world_body, 1e-12));
}

TEST(Trajectory, InterpolatesOnlyInside) {
  Trajectory t(2);
  t[0].utime = 1'000'000;
  t[1].utime = 1'400'000;
  t[1].T_world_body = planar_pose(4, 0, 0);
  const auto pose = pose_at(t, 1'100'000);
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->translation().x(), 1, 1e-12);
  EXPECT_TRUE(pose_at(t, 1'000'000));
  EXPECT_TRUE(pose_at(t, 1'400'000));
  EXPECT_FALSE(pose_at(t, 999'999));
  EXPECT_FALSE(pose_at(t, 1'400'001));
  EXPECT_FALSE(pose_at(t, 1'100'000, 0.3)) << "gap of 0.4 s";
  EXPECT_FALSE(pose_at({}, 0));
  EXPECT_NEAR(path_length(t), 4, 1e-12);
  EXPECT_EQ(path_length({}), 0);
}

}  // namespace
}  // namespace lcmslam
