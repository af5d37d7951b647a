#include <lcmslam/imaging/depth_error.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

CameraModel camera() {
  CameraModel c;
  c.width = 40, c.height = 30;
  c.fx = c.fy = 40, c.cx = 19.5, c.cy = 14.5;
  return c;
}

TEST(DepthError, IsUndone) {
  const DepthError error{0.02, 0.01, 0.006, 1.9, 0.7};
  for (double range = 0.4; range < 7; range += 0.1)
    EXPECT_NEAR(error.corrected(range + error.at(range)), range, 1e-9) << range;
}

// The error stands along the ray, depth along the axis: at the image's rim they differ by a third here.
TEST(DepthError, ImagesAreFreedOfItAlongTheirRays) {
  const CameraModel c = camera();
  const DepthError error{0.03, -0.005, 0.008, 1.5, 0.2};
  cv::Mat truth(c.height, c.width, CV_16UC1), measured(c.height, c.width, CV_16UC1);
  for (int v = 0; v < c.height; ++v)
    for (int u = 0; u < c.width; ++u) {
      const int z = u == 3 ? 0 : 800 + 60 * u + 20 * v;
      const double stretch = c.ray({u, v}).norm(), range = 1e-3 * z * stretch;
      truth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(z);
      measured.at<std::uint16_t>(v, u) =
          static_cast<std::uint16_t>(z == 0 ? 0 : 1e3 * (range + error.at(range)) / stretch + 0.5);
    }
  const DepthCorrector correct(c, error);
  correct(measured);
  cv::Mat difference;
  cv::absdiff(measured, truth, difference);
  double worst = 0;
  cv::minMaxLoc(difference, nullptr, &worst);
  EXPECT_LE(worst, 1) << "mm: what rounding leaves";
  EXPECT_EQ(measured.at<std::uint16_t>(5, 3), 0) << "no depth stays none";
  cv::Mat other(3, 3, CV_16UC1);
  EXPECT_THROW(correct(other), std::invalid_argument);
}

// At the rim here 10 mm at 1 m, 0.16 m at 4 m.
TEST(DepthError, ImagesAreFreedOfATiltOfInverseDepth) {
  const CameraModel c = camera();
  DepthError error{0.03, -0.005, 0.008, 1.5, 0.2};
  error.tilt_x = 0.02, error.tilt_y = -0.01;
  cv::Mat truth(c.height, c.width, CV_16UC1), measured(c.height, c.width, CV_16UC1);
  for (int v = 0; v < c.height; ++v)
    for (int u = 0; u < c.width; ++u) {
      const Eigen::Vector3d ray = c.ray({u, v});
      const double z = 0.8 + 0.06 * u + 0.02 * v, range = z * ray.norm();
      const double off_range = z * (range + error.at(range)) / range;
      truth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(1e3 * z + 0.5);
      measured.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(
          1e3 / (1 / off_range + error.tilt_x * ray.x() + error.tilt_y * ray.y()) + 0.5);
    }
  DepthCorrector(c, error)(measured);
  cv::Mat difference;
  cv::absdiff(measured, truth, difference);
  double worst = 0;
  cv::minMaxLoc(difference, nullptr, &worst);
  EXPECT_LE(worst, 1) << "mm: what rounding leaves";
  EXPECT_FALSE(error.is_zero());
  EXPECT_THROW((DepthError{0, 0, 0, 1, 0, 0.3, 0}.check()), std::invalid_argument);
  EXPECT_FALSE((DepthError{0, 0, 0, 1, 0, 0.01, 0} == DepthError{})) << "tables are made anew for it";
}

TEST(DepthError, AWiggleThatIsTooSteepIsRefused) {
  EXPECT_NO_THROW((DepthError{0, 0, 0.006, 1.9, 0}.check()));
  EXPECT_THROW((DepthError{0, 0, 0.2, 1, 0}.check()), std::invalid_argument);
  EXPECT_THROW((DepthError{2, 0, 0, 1, 0}.check()), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
