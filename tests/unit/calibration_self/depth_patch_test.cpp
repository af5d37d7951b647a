// Surfaces in a depth image: as wide as they are flat, and none where there is no plane.

#include <lcmslam/calibration/self/depth_patch.hpp>

#include <gtest/gtest.h>
#include <cmath>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

CameraModel camera() {
  CameraModel c;
  c.width = 320, c.height = 240, c.fx = c.fy = 290, c.cx = 159.5, c.cy = 119.5;
  return c;
}

const Eigen::Vector2d wall_middle(150.2, 110.7);

/// Inverse depth of a slanted wall, with the camera's noise.
double wall(int u, int v) {
  return 0.5 + 0.0008 * (u - 150) - 0.0004 * (v - 111);
}

template <class Surface>
cv::Mat seen(const Surface& surface, std::uint64_t seed) {
  cv::Mat image(camera().height, camera().width, CV_32FC1);
  Random random(seed);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      const double inverse = surface(u, v), z = 1 / inverse;
      image.at<float>(v, u) =
          inverse > 0 ? static_cast<float>(1 / (z + DepthNoise().sigma(z) * random.normal())) : 0.F;
    }
  return image;
}

// Over nine pixels noise tilts the slope by 1e-4 a pixel, over 37 by a tenth of that.
TEST(DepthPatch, TakesTheWidestPlane) {
  double worst = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto patch = depth_patch(seen(wall, seed), wall_middle, camera(), {});
    ASSERT_TRUE(patch) << seed;
    worst = std::max({worst, std::abs(patch->along_u - 0.0008), std::abs(patch->along_v + 0.0004)});
    EXPECT_NEAR(patch->inverse, wall(150, 111), 1e-3);
  }
  EXPECT_LT(worst, 2e-5);
}

// A bend that its noise hides in one patch does not lean the mean of many.
TEST(DepthPatch, ABulgesMiddleIsNotBehindIt) {
  constexpr double top = 0.6, behind = 3e-4;  // 1/m, by which the plane of 37 x 37 pixels would lie off
  const double bend = behind / (2 * 18 * 19 / 3.0);
  const auto bulge = [&](int u, int v) { return top - bend * (std::pow(u - 150, 2) + std::pow(v - 111, 2)); };
  double sum = 0;
  constexpr int seeds = 40;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const auto patch = depth_patch(seen(bulge, seed), wall_middle, camera(), {});
    ASSERT_TRUE(patch) << seed;
    EXPECT_NEAR(patch->along_u, 0, 5e-5);
    sum += patch->inverse - top;
  }
  EXPECT_NEAR(sum / seeds, 0, behind / 4);
}

TEST(DepthPatch, StaysOnItsSideOfAnEdge) {
  const auto before_a_door = [](int u, int v) { return u < 160 ? wall(u, v) : 0.3; };
  const auto patch = depth_patch(seen(before_a_door, 3), wall_middle, camera(), {});
  ASSERT_TRUE(patch);
  EXPECT_NEAR(patch->inverse, wall(150, 111), 2e-3);
  EXPECT_NEAR(patch->along_u, 0.0008, 5e-4);
  EXPECT_FALSE(depth_patch(seen(before_a_door, 3), {159, 111}, camera(), {})) << "on the edge";
}

TEST(DepthPatch, RefusesWhatIsNoPlane) {
  const auto ball = [](int u, int v) { return 0.6 - 2e-4 * (std::pow(u - 150, 2) + std::pow(v - 111, 2)); };
  const auto steep = [](int u, int) { return 0.5 + 0.012 * (u - 150); };
  const auto hole = [](int u, int v) { return (u + v) % 3 == 0 ? wall(u, v) : 0.; };
  const auto speckled = [](int u, int v) {
    const int n = 7 * u + 3 * v;
    return wall(u, v) + (n % 11 != 0 ? 0 : n % 2 == 0 ? 0.2 : -0.2);
  };
  EXPECT_FALSE(depth_patch(seen(speckled, 1), wall_middle, camera(), {}));
  EXPECT_FALSE(depth_patch(seen(ball, 1), wall_middle, camera(), {}));
  EXPECT_FALSE(depth_patch(seen(steep, 1), wall_middle, camera(), {}));
  EXPECT_FALSE(depth_patch(seen(hole, 1), wall_middle, camera(), {}));
  EXPECT_FALSE(depth_patch(seen(wall, 1), {2, 2}, camera(), {})) << "at the rim";
  EXPECT_FALSE(depth_patch(seen(wall, 1), {std::nan(""), 2}, camera(), {}));
}

}  // namespace
}  // namespace lcmslam
