#include <lcmslam/imaging/depth_filter.hpp>

#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/core.hpp>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

RgbdCalibration camera_of(int width, double sigma) {
  RgbdCalibration calibration;
  calibration.depth.width = width;
  calibration.depth.height = width * 3 / 4;
  calibration.depth.fx = calibration.depth.fy = width;
  calibration.depth_noise = {sigma, 0, 0, 0};
  return calibration;
}

DepthFilterSettings only(const std::string& part) {
  DepthFilterSettings settings;
  settings.parts = {part};
  return settings;
}

/// Depth of a plane z = distance + slope * x, with noise, mm.
cv::Mat plane(const RgbdCalibration& c, double distance, double slope, double sigma, std::uint64_t seed = 1) {
  Random random(seed);
  cv::Mat depth(c.depth.height, c.depth.width, CV_16UC1);
  const int centre = depth.cols / 2;
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const double x = (u - centre) / c.depth.fx;  // z = distance / (1 - slope x)
      const double z = distance / (1 - slope * x) + random.normal(0, sigma);
      depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(std::lround(1000 * z));
    }
  return depth;
}

int valid(const cv::Mat& depth) {
  return cv::countNonZero(depth);
}

class JumpEdges : public testing::TestWithParam<int> {};

// A wall 3 m away, a box at 2 m in front of it, mixed pixels all around the box, alike along its edges.
TEST_P(JumpEdges, MixedPixelsGoAndSurfacesStay) {
  const RgbdCalibration c = camera_of(GetParam(), 0.004);
  Random random(3);
  cv::Mat depth(c.depth.height, c.depth.width, CV_16UC1), mixed(depth.size(), CV_8UC1, cv::Scalar(0));
  const cv::Rect box(depth.cols / 3, depth.rows / 3, depth.cols / 3, depth.rows / 3);
  const cv::Rect inner(box.x + 1, box.y + 1, box.width - 2, box.height - 2);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      double z = inner.contains({u, v}) ? 2 : box.contains({u, v}) ? 2.4 : 3;
      mixed.at<std::uint8_t>(v, u) = z == 2.4;
      z += random.normal(0, 0.004);
      depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(std::lround(1000 * z));
    }
  const int good = valid(mixed == 0), bad = valid(mixed);
  DepthFilter filter(c, only("jump_edges"));
  filter(depth, {});
  EXPECT_LE(valid((depth != 0) & (mixed != 0)), 0.02 * bad);
  EXPECT_GE(valid((depth != 0) & (mixed == 0)), 0.95 * good);
}

// Steep surfaces are no edges, at any resolution and whether noise or slope is larger.
TEST_P(JumpEdges, SteepSurfacesStay) {
  for (const double sigma : {0.001, 0.004, 0.02})
    for (const double degrees : {0.0, 30.0, 60.0, 70.0}) {
      SCOPED_TRACE(testing::Message() << sigma << " m, " << degrees << " degrees");
      const RgbdCalibration c = camera_of(GetParam(), sigma);
      const double slope = std::tan(degrees * CV_PI / 180);
      cv::Mat depth = plane(c, 1.5, slope, sigma);
      // Towards the side the incidence grows to 90 degrees: in the middle quarter to 77.
      const cv::Rect middle(3 * depth.cols / 8, 0, depth.cols / 4, depth.rows);
      DepthFilter filter(c, only("jump_edges"));
      filter(depth, {});
      EXPECT_GE(valid(depth(middle)), 0.93 * middle.area());
    }
}

INSTANTIATE_TEST_SUITE_P(Widths, JumpEdges, testing::Values(176, 320, 640));

TEST(JumpEdgeFilter, ImageBordersAndHolesAreNoEdges) {
  const RgbdCalibration c = camera_of(64, 0.002);
  cv::Mat depth = plane(c, 2, 0, 0);
  depth(cv::Rect(20, 10, 5, 7)).setTo(0);
  const cv::Mat before = depth.clone();
  DepthFilter filter(c, only("jump_edges"));
  filter(depth, {});
  EXPECT_EQ(cv::norm(depth, before, cv::NORM_INF), 0);
}

TEST(JumpEdgeFilter, ForwardAndMirroredImagesAreJudgedAlike) {
  const RgbdCalibration c = camera_of(96, 0.01);
  cv::Mat depth = plane(c, 2, 1, 0.02, 5);
  depth(cv::Rect(30, 20, 25, 25)) -= 400;
  cv::Mat mirrored, turned;
  cv::flip(depth, mirrored, -1);
  DepthFilter filter(c, only("jump_edges"));
  filter(depth, {});
  filter(mirrored, {});
  cv::flip(mirrored, turned, -1);
  EXPECT_EQ(cv::norm(depth, turned, cv::NORM_INF), 0);
  EXPECT_LT(valid(depth), static_cast<int>(depth.total()));
}

TEST(SpeckleFilter, SmallIslandsGo) {
  const RgbdCalibration c = camera_of(200, 0.002);  // 1e-4 sr are 4 pixels
  cv::Mat depth(c.depth.height, c.depth.width, CV_16UC1, cv::Scalar(0));
  depth(cv::Rect(10, 10, 3, 1)).setTo(1000);
  depth(cv::Rect(30, 10, 2, 2)).setTo(1000);
  depth(cv::Rect(50, 10, 2, 1)).setTo(1000);  // a stair: three rows, each touching the next
  depth(cv::Rect(51, 11, 2, 1)).setTo(1000);
  depth(cv::Rect(70, 10, 1, 1)).setTo(1000);  // a U: joined at the bottom only
  depth(cv::Rect(72, 10, 1, 1)).setTo(1000);
  depth(cv::Rect(70, 11, 3, 1)).setTo(1000);
  depth(cv::Rect(90, 10, 1, 1)).setTo(1000);  // touch at corners only
  depth(cv::Rect(91, 11, 3, 1)).setTo(1000);
  DepthFilter filter(c, only("speckle"));
  filter(depth, {});
  EXPECT_EQ(valid(depth(cv::Rect(5, 5, 20, 20))), 0);
  EXPECT_EQ(valid(depth(cv::Rect(25, 5, 20, 20))), 4);
  EXPECT_EQ(valid(depth(cv::Rect(45, 5, 20, 20))), 4);
  EXPECT_EQ(valid(depth(cv::Rect(65, 5, 20, 20))), 5);
  EXPECT_EQ(valid(depth(cv::Rect(85, 5, 20, 20))), 0);
}

TEST(AmplitudeFilter, DarkPixelsGo) {
  const RgbdCalibration c = camera_of(64, 0.002);
  cv::Mat depth = plane(c, 2, 0, 0), amplitude(depth.size(), CV_8UC1, cv::Scalar(200));
  amplitude.row(3).setTo(5);
  amplitude.row(4).setTo(6);  // 0.02 x 255 = 5.1
  DepthFilter filter(c, only("amplitude"));
  filter(depth, amplitude);
  EXPECT_EQ(valid(depth.row(3)), 0);
  EXPECT_EQ(valid(depth.row(4)), 64);
  EXPECT_EQ(valid(depth), 64 * 47);
  filter(depth, {});
  EXPECT_EQ(valid(depth), 64 * 47);
}

TEST(BilateralFilter, NoiseFallsAndEdgesAndSlopesStay) {
  const double sigma = 0.01;
  RgbdCalibration c = camera_of(320, 0);
  c.depth_noise.amplitude = sigma / 4;  // at 2 m
  cv::Mat depth = plane(c, 2, 0.5, sigma);
  const cv::Mat exact = plane(c, 2, 0.5, 0);
  const cv::Rect box(100, 80, 60, 60);
  depth(box) -= 300;
  exact(box) -= 300;
  const auto error = [&](const cv::Mat& image) {
    return cv::norm(image, exact, cv::NORM_L2) / std::sqrt(static_cast<double>(image.total()));
  };
  const double before = error(depth);
  DepthFilter filter(c, only("bilateral"));
  filter(depth, {});
  EXPECT_LT(error(depth), 0.55 * before);
  EXPECT_LT(cv::norm(depth, exact, cv::NORM_INF), 50);  // nothing between the surfaces
  EXPECT_NEAR(cv::mean(depth)[0], cv::mean(exact)[0], 0.5);
}

// What is told of the noise that stays is what stays, wherever the noise is small against the slope or not.
TEST(BilateralFilter, TellsHowMuchNoiseIsLeft) {
  const double sigma = 0.02;
  for (const double range_sigmas : {1.5, 3.0, 6.0}) {
    SCOPED_TRACE(range_sigmas);
    RgbdCalibration c = camera_of(320, 0);
    c.depth_noise.amplitude = sigma / 4;  // at 2 m
    DepthFilterSettings settings = only("bilateral");
    settings.bilateral.range_sigmas = range_sigmas;
    DepthFilter filter(c, settings);
    cv::Mat depth = plane(c, 2, 0.1, sigma, 5), off;
    filter(depth, {});
    cv::subtract(depth, plane(c, 2, 0.1, 0), off, {}, CV_64F);
    const cv::Rect inside(4, 4, depth.cols - 8, depth.rows - 8);
    const double left =
        cv::norm(off(inside)) / std::sqrt(static_cast<double>(inside.area())) / (1000 * sigma);
    EXPECT_NEAR(filter.noise_left() / left, 1, 0.06) << left;
  }
}

TEST(BilateralFilter, LeavesCamerasAloneWhoseNeighbouringPixelsShareTheirErrors) {
  const RgbdCalibration c = camera_of(64, 0.01);
  cv::Mat depth = plane(c, 2, 0, 0.01);
  const cv::Mat before = depth.clone();
  DepthFilter filter(c, only("bilateral"));
  filter(depth, {});
  EXPECT_EQ(cv::norm(depth, before, cv::NORM_INF), 0);
  EXPECT_EQ(filter.noise_left(), 1);
}

TEST(DepthFilter, SizesMayChangeAndSameInputGivesSameOutput) {
  RgbdCalibration c = camera_of(64, 0.01);
  c.depth_noise.amplitude = 0.001;
  DepthFilterSettings all;
  all.parts = DepthFilterSettings().parts;
  DepthFilter filter(c, all), other(c, all);
  cv::Mat small = plane(c, 2, 0, 0.05), large = plane(camera_of(96, 0.01), 2, 0, 0.05);
  cv::Mat small_again = small.clone();
  filter(small, {});
  filter(large, {});
  other(small_again, {});
  EXPECT_EQ(cv::norm(small, small_again, cv::NORM_INF), 0);
}

TEST(DepthFilter, RefusesWhatItDoesNotKnow) {
  const RgbdCalibration c = camera_of(64, 0.01);
  EXPECT_THROW(DepthFilter(c, only("median")), std::invalid_argument);
  DepthFilter filter(c);
  cv::Mat bytes(48, 64, CV_8UC1, cv::Scalar(0)), depth(48, 64, CV_16UC1, cv::Scalar(0));
  EXPECT_THROW(filter(bytes, {}), std::invalid_argument);
  EXPECT_THROW(filter(depth, cv::Mat(48, 63, CV_8UC1)), std::invalid_argument);
  filter(depth, {});  // nothing measured: nothing to do
  EXPECT_EQ(valid(depth), 0);
}

}  // namespace
}  // namespace lcmslam
