#include <lcmslam/simulation/depth_camera.hpp>

#include <gmock/gmock.h>

#include <set>

#include "tests/unit/simulation/box_room.hpp"

namespace lcmslam {
namespace {

CameraModel model() {
  return pinhole_camera(640, 480, 590);
}

cv::Mat shoot(const Scene& scene, const Eigen::Isometry3d& T_world_camera = level_camera()) {
  const RayCaster caster(scene);
  return DepthCamera(scene, caster, model()).render(T_world_camera, PixelNoise(1, 2, 0), 1);
}

class DepthAtDistance : public testing::TestWithParam<double> {};

TEST_P(DepthAtDistance, NoiseAndQuantisationArePinned) {
  const double z = GetParam();
  const cv::Mat depth = shoot(box_room(z));
  std::vector<double> errors;
  std::set<int> values;
  for (int y = 140; y < 340; ++y)
    for (int x = 220; x < 420; ++x) {
      const int value = depth.at<std::uint16_t>(y, x);
      ASSERT_GT(value, 0);
      errors.push_back(value * 0.001 - z);
      values.insert(value);
    }
  // Neighbouring disparities (1/8 pixel) are z^2 / (8 f b) apart.
  const double step = z * z / (8 * 590 * 0.075), sigma = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
  const Moments m = moments(errors);
  EXPECT_NEAR(m.mean, 0, 0.2 * sigma + 0.5 * step);
  if (step < 2 * sigma) {
    EXPECT_NEAR(m.deviation, std::hypot(sigma, step / std::sqrt(12.0)), 0.1 * sigma + 0.0003);
  }
  for (const int value : values) {
    const double disparity = 590 * 0.075 / (value * 0.001) * 8;
    EXPECT_NEAR(disparity, std::round(disparity), 0.5 * 0.001 / step + 1e-9) << value << " mm";
  }
}

INSTANTIATE_TEST_SUITE_P(Distances, DepthAtDistance, testing::Values(0.8, 1.5, 2.5, 4.0));

TEST(DepthCamera, HolesBehindEdgesOnly) {
  const cv::Mat depth =
      shoot(box_room(3, "boxes: [{at: [1.6, 0, 0], size: [0.2, 0.6, 3], material: red}]\n"));
  const int right = static_cast<int>(319.5 + 590 * 0.3 / 1.5);  // last column of the box
  const auto* row = depth.ptr<std::uint16_t>(240);
  EXPECT_GT(row[right - 1], 0);
  EXPECT_EQ(row[right + 2], 0);
  EXPECT_GT(row[right + 6], 0);
  for (int x = right + 2; x < 640; ++x) EXPECT_TRUE(row[x] == 0 || row[x] > 2800);  // no mixed values
}

TEST(DepthCamera, GrazingSurfacesReturnNothing) {
  // Near the floor the camera sees it at flat angles: 2 m ahead at height 0.2 m, 5.7 degrees.
  const Eigen::Isometry3d low = Eigen::Translation3d(0, 0, 0.2) * optical_axes();
  const cv::Mat depth = shoot(box_room(6), low);
  const auto row_of = [](double distance) { return static_cast<int>(239.5 + 590 * 0.2 / distance); };
  EXPECT_EQ(depth.at<std::uint16_t>(row_of(2.0), 320), 0);
  EXPECT_GT(depth.at<std::uint16_t>(row_of(0.7), 320), 0);
}

}  // namespace
}  // namespace lcmslam
