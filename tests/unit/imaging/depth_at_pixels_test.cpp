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

// What OpenCV fits to an ordinary lens with 8 coefficients: it folds in a ring that the check of the model's
// samples does not see.
TEST(DepthAtPixels, NothingWhereARationalLensFolds) {
  for (const bool registered : {false, true}) {
    RgbdCalibration calibration;
    calibration.colour = {640,
                          480,
                          369.2417,
                          369.2805,
                          320.3526,
                          239.9039,
                          {-0.95443936648, 0.29391769320, -2.7489448e-05, -4.4400921e-05, -0.07810608849,
                           -0.68089654476, 0.03337224300, -0.02890496422}};
    calibration.depth = calibration.colour;
    calibration.depth_registered = registered;
    if (!registered) {
      calibration.depth = {640, 480, 500, 500, 320, 240, {}};
      calibration.T_colour_depth.translation() << 0.025, 0, 0;
    }
    ASSERT_NO_THROW(calibration.colour.check("colour"));
    std::vector<cv::Point2f> queries{{100, 100}, {320, 240}};
    for (int v = 0; v < 480; v += 7)
      for (int u = 0; u < 640; u += 13)
        if (!calibration.colour.ray({u, v}).allFinite())
          queries.emplace_back(static_cast<float>(u), static_cast<float>(v));
    ASSERT_GT(queries.size(), 2U);
    RgbdFrame frame;
    frame.depth = cv::Mat(480, 640, CV_16UC1, cv::Scalar(1500));
    DepthRegistration registration(calibration);
    for (const float left : {100.F, 102.F, 104.F, 106.F}) {  // whatever the size of what is looked at
      queries.front().x = left;
      const auto found = registration.depth_at_pixels(frame, queries);
      EXPECT_TRUE(found.at(1).point.allFinite());
      for (std::size_t i = 2; i < found.size(); ++i) {
        EXPECT_TRUE(std::isnan(found[i].sigma)) << queries[i];
        EXPECT_FALSE(found[i].point.allFinite()) << queries[i];
      }
    }
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
