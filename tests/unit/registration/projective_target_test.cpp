#include <lcmslam/registration/projective_target.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

// What the camera saw in a cell is found from any point on its ray.
TEST(ProjectiveTarget, FindsWhatTheCameraSawThere) {
  ProjectionGrid grid;
  Cloud cloud;
  for (int v = 0; v < grid.height; ++v)
    for (int u = 0; u < grid.width; ++u) {
      const double z = 2 + 0.3 * std::sin(0.05 * u);
      const Eigen::Vector3d p(z * (u - grid.cx) / grid.fx, z * (v - grid.cy) / grid.fy, z);
      cloud.points.push_back(p.cast<float>());
    }
  const Eigen::Isometry3d T_target_camera = se3_exp(twist(1, 2, 3, 0.3, -0.2, 0.1));
  const Cloud in_target = transformed(cloud, T_target_camera);
  const ProjectiveTarget target(in_target, T_target_camera, grid, 0);
  EXPECT_EQ(target.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); i += 97) {
    TargetPoint found;
    const Eigen::Vector3d on_ray = T_target_camera * (1.03 * cloud.points[i].cast<double>());
    ASSERT_TRUE(target.find(on_ray.cast<float>(), 0.2f, found));
    EXPECT_EQ(found.point, in_target.points[i]);
    EXPECT_FALSE(target.find(on_ray.cast<float>(), 0.01f, found));
  }
}

TEST(ProjectiveTarget, TheNearerSurfaceHidesTheFarther) {
  Cloud cloud;
  cloud.points = {{0, 0, 3}, {0, 0, 2}, {0, 0, 4}};
  const ProjectiveTarget target(cloud, Eigen::Isometry3d::Identity());
  TargetPoint found;
  ASSERT_TRUE(target.find({0, 0, 3}, 5, found));
  EXPECT_EQ(found.point.z(), 2);
  EXPECT_FALSE(target.find({0, 0, -3}, 50, found));   // behind
  EXPECT_FALSE(target.find({50, 0, 3}, 500, found));  // beside
}

}  // namespace
}  // namespace lcmslam
