// Depth at places between the depth camera's pixels, and where there is none: on registered images made by
// hand.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include <lcmslam/imaging/depth_registration.hpp>

namespace lcmslam {
namespace {

constexpr int columns = 100, rows = 80;
constexpr float focal = 100;
constexpr float nothing = std::numeric_limits<float>::quiet_NaN();

RgbdCalibration head() {
  RgbdCalibration calibration;
  calibration.depth_registered = true;
  calibration.colour.width = columns;
  calibration.colour.height = rows;
  calibration.colour.fx = calibration.colour.fy = focal;
  calibration.colour.cx = 50;
  calibration.colour.cy = 40;
  calibration.depth = calibration.colour;
  calibration.pixel_sigma = 0.8;
  return calibration;
}

/// depth(u, v) in m, NaN where there is none.
RegisteredDepth image_of(const std::function<float(int, int)>& depth, float sigma) {
  RegisteredDepth image;
  image.points.create(rows, columns, CV_32FC3);
  image.sigma = cv::Mat(rows, columns, CV_32FC1, cv::Scalar(sigma));
  image.pitch = 1 / focal;
  image.aligned = true;
  for (int v = 0; v < rows; ++v)
    for (int u = 0; u < columns; ++u) {
      const float z = depth(u, v);
      image.points.at<cv::Vec3f>(v, u) = {z * static_cast<float>(u - 50) / focal,
                                          z * static_cast<float>(v - 40) / focal, z};
    }
  return image;
}

DepthAtPixel depth_at(const RegisteredDepth& image, float u, float v) {
  return depth_at_pixels(image, head(), {{u, v}}).at(0);
}

TEST(DepthAtPixels, AWallHasItsDepthAndTheSensorsNoise) {
  const DepthAtPixel found = depth_at(image_of([](int, int) { return 2.f; }, 0.005f), 30.3f, 41.6f);
  EXPECT_NEAR(found.point.z(), 2, 1e-5);
  EXPECT_NEAR(found.point.x(), 2 * (30.3 - 50) / focal, 1e-4);
  EXPECT_NEAR(found.sigma, 0.005, 1e-6);
}

TEST(DepthAtPixels, OnASlopeTheUncertainPixelCountsToo) {
  // 1 / z is linear in the pixel for a plane.
  const auto inverse = [](float u) { return 0.5f + 0.004f * (u - 50); };
  const DepthAtPixel found = depth_at(
      image_of([&](int u, int) { return 1 / inverse(static_cast<float>(u)); }, 0.003f), 60.4f, 20.7f);
  const double z = 1 / static_cast<double>(inverse(60.4f));
  EXPECT_NEAR(found.point.z(), z, 1e-4);
  const double slope = 0.004 * z * z;  // m a pixel
  EXPECT_NEAR(found.sigma, std::hypot(0.003, 0.8 * slope), 1e-5);
}

TEST(DepthAtPixels, NothingBeyondTheEndOfASurface) {
  const RegisteredDepth image = image_of([](int u, int) { return u < 50 ? 2.f : nothing; }, 0.005f);
  EXPECT_TRUE(depth_at(image, 48.4f, 40.5f).point.allFinite());
  EXPECT_FALSE(depth_at(image, 49.4f, 40.5f).point.allFinite());
  EXPECT_FALSE(depth_at(image, 55, 40).point.allFinite());
}

TEST(DepthAtPixels, NothingOnAStep) {
  for (const float step : {0.06f, 0.3f, 1.f}) {
    const RegisteredDepth image = image_of([&](int u, int) { return u < 50 ? 2.f : 2 + step; }, 0.003f);
    EXPECT_FALSE(depth_at(image, 49, 40).point.allFinite()) << step << " m";
    EXPECT_TRUE(depth_at(image, 47, 40).point.allFinite()) << step << " m";
  }
}

TEST(EstimateNormals, LookAtTheCamera) {
  const cv::Mat normals = estimate_normals(image_of([](int, int) { return 2.f; }, 0.002f));
  const cv::Vec3f n = normals.at<cv::Vec3f>(40, 50);
  EXPECT_NEAR(n[0], 0, 1e-3);
  EXPECT_NEAR(n[1], 0, 1e-3);
  EXPECT_NEAR(n[2], -1, 1e-3);
}

TEST(EstimateNormals, BesideAStepAreThoseOfTheirOwnSurface) {
  const cv::Mat normals = estimate_normals(image_of([](int u, int) { return u < 50 ? 2.f : 3.f; }, 0.001f));
  for (const int u : {47, 48, 51, 52}) {
    const cv::Vec3f n = normals.at<cv::Vec3f>(40, u);
    EXPECT_LT(n[2], -0.99f) << "column " << u;  // NaN fails
  }
}

}  // namespace
}  // namespace lcmslam
