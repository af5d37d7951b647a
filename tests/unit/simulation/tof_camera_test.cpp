#include <lcmslam/simulation/tof_camera.hpp>

#include <gmock/gmock.h>

#include "tests/unit/simulation/box_room.hpp"

namespace lcmslam {
namespace {

struct Shot {
  Scene scene;
  TofImage image;
};

Shot shoot_tof(Scene scene, std::uint64_t seed = 1) {
  const RayCaster caster(scene);
  TofImage image = TofCamera(scene, caster, tof_model()).render(level_camera(), PixelNoise(seed, 2, 0), 1);
  return {std::move(scene), image};
}

/// Pixels whose rays meet the wall ahead well away from its edges.
template <class Visit>
void for_wall_pixels(Visit visit) {
  for (int y = 40; y < 104; ++y)
    for (int x = 30; x < 146; ++x) visit(x, y);
}

class TofAtDistance : public testing::TestWithParam<double> {};

// The wall ahead is a plane z = distance: after taking off wiggle and scaling by the pinned sigma the
// errors must be standard normal.
TEST_P(TofAtDistance, DepthFollowsTheNoiseModel) {
  const double distance = GetParam();
  const Shot shot = shoot_tof(box_room(distance));
  std::vector<double> errors;
  for_wall_pixels([&](int x, int y) {
    const double per_z = tof_model().ray(Eigen::Vector2d(x, y)).norm();
    const double range = distance * per_z, cosine = 1 / per_z;
    const double wiggle = 0.006 * std::sin(2 * M_PI * range / 1.9);
    const double sigma = 0.001 * range * range / std::sqrt(0.64 * cosine);
    const double rounding = 0.001 / std::sqrt(12.0) * per_z;
    ASSERT_GT(shot.image.depth.at<std::uint16_t>(y, x), 0);
    const double measured = shot.image.depth.at<std::uint16_t>(y, x) * 0.001 * per_z;
    errors.push_back((measured - range - wiggle) / std::hypot(sigma, rounding));
  });
  const Moments m = moments(errors);
  EXPECT_NEAR(m.mean, 0, 0.06);
  EXPECT_NEAR(m.deviation, 1, 0.03);
}

INSTANTIATE_TEST_SUITE_P(Distances, TofAtDistance, testing::Values(0.6, 1.0, 1.5, 2.4, 3.7, 5.0));

TEST(TofCamera, AmplitudeFallsWithTheSquareOfTheRange) {
  const double near = shoot_tof(box_room(1)).image.amplitude.at<float>(72, 88);
  const double far = shoot_tof(box_room(3)).image.amplitude.at<float>(72, 88);
  EXPECT_NEAR(near, 0.64, 0.01);
  EXPECT_NEAR(near / far, 9, 0.05);
}

// The published image is range-corrected, so that amplitude/255 is what the depth noise model asks for.
TEST(TofCamera, GreyIsReflectivityTimesCosine) {
  for (const double distance : {1.0, 3.0})
    EXPECT_NEAR(shoot_tof(box_room(distance)).image.grey.at<std::uint8_t>(72, 88), 0.64 * 255, 2);
}

TEST(TofCamera, MixedPixelsAppearAtDepthEdgesOnly) {
  const Shot shot =
      shoot_tof(box_room(3, "boxes: [{at: [1.6, 0.3, 0], size: [0.2, 0.61, 3], material: red}]\n"));
  // The box's front is 1.5 m away, from y = -0.005 to 0.605.
  int mixed = 0;
  for (int y = 40; y < 104; ++y)
    for (int x = 30; x < 146; ++x) {
      const double z = shot.image.depth.at<std::uint16_t>(y, x) * 0.001;
      if (z < 1.62 || z > 2.8) continue;
      ++mixed;
      const double right = 87.5 + 200 * 0.005 / 1.5, left = 87.5 - 200 * 0.605 / 1.5;
      EXPECT_LT(std::min(std::abs(x - right), std::abs(x - left)), 1.5)
          << "mixed pixel in a surface at x " << x;
    }
  EXPECT_GT(mixed, 30);
}

TEST(TofCamera, WhatIsTooFarIsMeasuredOneTurnTooNearAndDark) {
  const cv::Rect middle(80, 64, 16, 16);
  const TofImage image = shoot_tof(box_room(9, "", 0.8)).image;
  const cv::Scalar depth = cv::mean(image.depth(middle)), grey = cv::mean(image.grey(middle));
  EXPECT_NEAR(depth[0], 1500, 40);  // sigma 0.09 m a pixel
  EXPECT_NEAR(grey[0], 255 * 0.8 * std::pow(1.5 / 9, 2), 2);
  TofSensor several_frequencies;
  several_frequencies.folds = false;
  const Scene scene = box_room(9, "", 0.8);
  const RayCaster caster(scene);
  const TofImage told = TofCamera(scene, caster, tof_model(), several_frequencies)
                            .render(level_camera(), PixelNoise(1, 2, 0), 1);
  EXPECT_EQ(cv::countNonZero(told.depth(middle)), 0);
}

TEST(TofCamera, TooNearAndTooDarkAreInvalid) {
  EXPECT_EQ(cv::countNonZero(shoot_tof(box_room(0.25)).image.depth(cv::Rect(80, 64, 16, 16))), 0);
  EXPECT_EQ(cv::countNonZero(shoot_tof(box_room(4, "", 0.01)).image.depth(cv::Rect(80, 64, 16, 16))), 0);
  EXPECT_EQ(cv::countNonZero(shoot_tof(box_room(1, "", 0.01)).image.depth(cv::Rect(80, 64, 16, 16))), 256);
}

TEST(TofCamera, SameBytesForEveryThreadCount) {
  const Scene scene = box_room(3);
  const RayCaster caster(scene);
  const TofCamera camera(scene, caster, tof_model());
  const PixelNoise noise(5, 2, 77);
  const TofImage one = camera.render(level_camera(), noise, 1),
                 three = camera.render(level_camera(), noise, 3);
  EXPECT_EQ(cv::norm(one.depth, three.depth, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(one.grey, three.grey, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace lcmslam
