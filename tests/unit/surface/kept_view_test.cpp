#include <gtest/gtest.h>

#include <lcmslam/surface/depth_deltas.hpp>
#include <lcmslam/surface/halved_image.hpp>
#include <lcmslam/surface/kept_view.hpp>

namespace lcmslam {
namespace {

cv::Mat random_depth(int rows, int columns) {
  cv::Mat depth(rows, columns, CV_16UC1), jumps(rows, columns, CV_8UC1);
  cv::RNG random(3);
  random.fill(depth, cv::RNG::UNIFORM, 900, 1100);
  random.fill(jumps, cv::RNG::UNIFORM, 0, 10);
  depth.setTo(0, jumps == 0);
  depth.setTo(65535, jumps == 1);
  return depth;
}

TEST(KeptView, KeepsDepthBitByBit) {
  cv::Mat depth = random_depth(20, 30);
  const int steps[] = {500, 627, 500, 628, 500, 373, 500, 372, 501};  // 127 and 128, up and down
  for (int u = 0; u < 9; ++u) depth.at<std::uint16_t>(7, u) = static_cast<std::uint16_t>(steps[u]);
  EXPECT_EQ(cv::countNonZero(unpack_depth(pack_depth(depth), depth.size()) != depth), 0);

  SurfaceImage image;
  image.depth = depth;
  image.amplitude = cv::Mat(depth.size(), CV_8UC1, cv::Scalar(77));
  image.colour = cv::Mat(depth.size(), CV_8UC3, cv::Scalar(20, 60, 200));
  image.seen = depth > 1000;
  const SurfaceImage unpacked = KeptView(image).unpacked();
  EXPECT_EQ(cv::countNonZero(unpacked.depth != depth), 0);
  EXPECT_EQ(cv::countNonZero(unpacked.amplitude != image.amplitude), 0);
  EXPECT_EQ(cv::countNonZero(unpacked.seen != image.seen), 0);
}

TEST(KeptView, OfASmoothSurfaceTakesAByteAPixel) {
  const cv::Mat depth(100, 100, CV_16UC1, cv::Scalar(2000));
  EXPECT_LT(pack_depth(depth).size(), 10'010u);
}

/// The mean of what belongs to the nearest of four pixels.
int one_of_four(const cv::Mat& four) {
  int nearest = 1 << 16, sum = 0, count = 0;
  for (int i = 0; i < 4; ++i)
    if (const int d = four.at<std::uint16_t>(i / 2, i % 2); d > 0) nearest = std::min(nearest, d);
  for (int i = 0; i < 4; ++i) {
    const int d = four.at<std::uint16_t>(i / 2, i % 2);
    if (d == 0 || d > nearest + nearest / 32) continue;
    sum += d;
    ++count;
  }
  return count > 0 ? (2 * sum + count) / (2 * count) : 0;
}

TEST(HalvedImage, NoMeanOverAnEdge) {
  const cv::Mat depth = random_depth(40, 62), half = halved_depth(depth);
  ASSERT_EQ(half.size(), cv::Size(31, 20));
  for (int v = 0; v < half.rows; ++v)
    for (int u = 0; u < half.cols; ++u)
      ASSERT_EQ(half.at<std::uint16_t>(v, u), one_of_four(depth({2 * u, 2 * v, 2, 2}))) << u << " " << v;
}

}  // namespace
}  // namespace lcmslam
