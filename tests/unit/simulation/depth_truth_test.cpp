#include <lcmslam/simulation/depth_truth.hpp>

#include <gmock/gmock.h>

#include "tests/unit/simulation/box_room.hpp"

namespace lcmslam {
namespace {

/// A box whose front is 1.5 m away, from y = -0.005 to 0.605, before a wall at 3 m.
const char* const box = "boxes: [{at: [1.6, 0.3, 0], size: [0.2, 0.61, 3], material: red}]\n";

cv::Mat classes_of(const Scene& scene, const cv::Mat& depth, const cv::Mat& amplitude = {},
                   const Eigen::Isometry3d& T = level_camera(), cv::Mat* gap = nullptr) {
  const RayCaster caster(scene);
  return DepthTruth(scene, caster, tof_model(), noise_tolerance(TofSensor()))
      .classify(depth, amplitude, T, 1, gap);
}

DepthClass at(const cv::Mat& classes, int v, int u) {
  return static_cast<DepthClass>(classes.at<std::uint8_t>(v, u));
}

TEST(DepthTruth, ValuesBetweenTheSurfacesOfAPixelAreMixed) {
  const Scene scene = box_room(3, box);
  const int right = static_cast<int>(std::lround(87.5 + 200 * 0.005 / 1.5));  // the box's last column
  const auto judged = [&](int column, int millimetres) {
    return at(classes_of(scene, cv::Mat(144, 176, CV_16UC1, cv::Scalar(millimetres))), 72, column);
  };
  EXPECT_EQ(judged(right, 1500), DepthClass::good);
  EXPECT_EQ(judged(right, 3000), DepthClass::good);
  EXPECT_EQ(judged(right, 1512), DepthClass::good);  // 3 sigma and wiggle: 6.75 + 6 mm
  EXPECT_EQ(judged(right, 1514), DepthClass::mixed);
  EXPECT_EQ(judged(right, 2200), DepthClass::mixed);
  EXPECT_EQ(judged(right, 0), DepthClass::none);
  EXPECT_EQ(judged(right + 3, 2200), DepthClass::off);  // only the wall is there
  EXPECT_EQ(judged(right + 3, 3000), DepthClass::good);
}

TEST(DepthTruth, SlopesAndCornersAreOneSurface) {
  // The camera looks steeply along the floor: the depth within a pixel varies by far more than the noise.
  const Scene scene = box_room(6);
  const Eigen::Isometry3d low = Eigen::Translation3d(0, 0, 0.2) * optical_axes();
  const RayCaster caster(scene);
  const TofCamera camera(scene, caster, tof_model());
  const TofImage image = camera.render(low, PixelNoise(1, 2, 0), 1);
  const cv::Mat classes = classes_of(scene, image.depth, image.grey, low);
  const int mixed = cv::countNonZero(classes == static_cast<int>(DepthClass::mixed));
  const int good = cv::countNonZero(classes == static_cast<int>(DepthClass::good));
  EXPECT_LT(mixed, 20);
  EXPECT_GT(cv::countNonZero(image.depth), 20000);
  EXPECT_GT(good, 0.99 * cv::countNonZero(image.depth));
}

TEST(DepthTruth, TheSensorsMixedPixelsAreFoundAtTheEdgesAlone) {
  const Scene scene = box_room(3, box);
  const RayCaster caster(scene);
  const TofImage image = TofCamera(scene, caster, tof_model()).render(level_camera(), PixelNoise(1, 2, 0), 1);
  cv::Mat gap;
  const cv::Mat classes = classes_of(scene, image.depth, image.grey, level_camera(), &gap);
  int mixed = 0;
  for (int v = 40; v < 104; ++v)
    for (int u = 30; u < 146; ++u) {
      const double z = image.depth.at<std::uint16_t>(v, u) * 0.001;
      if (z > 1.62 && z < 2.8) {
        EXPECT_EQ(at(classes, v, u), DepthClass::mixed) << u << " " << v;
      }
      if (at(classes, v, u) != DepthClass::mixed) continue;
      ++mixed;
      EXPECT_GT(gap.at<float>(v, u), 1);
      const double right = 87.5 + 200 * 0.005 / 1.5, left = 87.5 - 200 * 0.605 / 1.5;
      EXPECT_LT(std::min(std::abs(u - right), std::abs(u - left)), 1.5);
    }
  EXPECT_GT(mixed, 60);
}

TEST(DepthTruth, RefusesImagesOfAnotherSize) {
  const Scene scene = box_room(3);
  EXPECT_THROW(classes_of(scene, cv::Mat(10, 10, CV_16UC1, cv::Scalar(0))), std::invalid_argument);
  const RayCaster caster(scene);
  EXPECT_THROW(DepthTruth(scene, caster, tof_model(), noise_tolerance(TofSensor()), 0),
               std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
