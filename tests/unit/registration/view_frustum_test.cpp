#include <lcmslam/registration/view_frustum.hpp>

#include <gtest/gtest.h>

#include "tests/support/cloud_scenes.hpp"
#include "tests/support/vga_camera.hpp"

namespace lcmslam {
namespace {

TEST(ViewFrustum, HoldsWhatTheImageShows) {
  const CameraModel c = vga_camera();
  const ViewFrustum frustum(c);
  Random random(1);
  int inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-1, 4));
    const auto pixel = c.project(p);
    const bool shown = pixel && c.contains(*pixel);
    EXPECT_EQ(frustum.contains(p.cast<float>()), shown) << p.transpose();
    inside += shown ? 1 : 0;
  }
  EXPECT_GT(inside, 1000);
  EXPECT_FALSE(frustum.contains({0, 0, 0}));
  EXPECT_FALSE(frustum.contains({0, 0, -1}));
  EXPECT_FALSE(frustum.contains(Eigen::Vector3f::Constant(NAN)));
  EXPECT_THROW(ViewFrustum{CameraModel()}, std::invalid_argument);
}

TEST(ViewFrustum, KeepsPointsWithAllThatIsKnownOfThem) {
  Cloud cloud = room();
  cloud.sigmas.assign(cloud.size(), 0.01f);
  const Eigen::Isometry3d T_camera_cloud = optical_axes().inverse();
  const Cloud inside = points_inside(cloud, ViewFrustum(vga_camera()), T_camera_cloud);
  EXPECT_GT(inside.size(), 100U);
  EXPECT_LT(inside.size(), cloud.size());
  EXPECT_EQ(inside.normals.size(), inside.size());
  EXPECT_EQ(inside.sigmas.size(), inside.size());
}

}  // namespace
}  // namespace lcmslam
