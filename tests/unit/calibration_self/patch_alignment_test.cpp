// A texture is found again to a tenth of a pixel, however it is seen, and another one is not.

#include <lcmslam/calibration/self/patch_alignment.hpp>

#include <gtest/gtest.h>
#include <cmath>

namespace lcmslam {
namespace {

/// A smooth texture that repeats nowhere near.
double grey(double x, double y) {
  return 120 + 40 * std::sin(0.31 * x + 0.12 * y) + 30 * std::cos(0.27 * y - 0.08 * x) +
         25 * std::sin(0.019 * x * x / 10 + 0.4 * y);
}

/// What is at x in the texture is at warp(x - texture_middle) in the image.
const Eigen::Vector2d texture_middle(60.3, 58.8);

cv::Mat seen_by(const PatchWarp& warp, double gain, double offset) {
  cv::Mat image(120, 120, CV_8UC1);
  const Eigen::Matrix2d back = warp.A.inverse();
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      const Eigen::Vector2d x = back * (Eigen::Vector2d(u, v) - warp.t) + texture_middle;
      image.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(gain * grey(x.x(), x.y()) + offset);
    }
  return image;
}

PatchWarp straight() {
  PatchWarp warp;
  warp.t = texture_middle;
  return warp;
}

PatchWarp slanted() {
  PatchWarp warp;
  warp.A << 0.9, 0.12, -0.1, 1.15;
  warp.t << 52.4, 63.7;
  return warp;
}

constexpr int patch_radius = 9;

TEST(PatchAlignment, FindsASlantedTextureInOtherLight) {
  const cv::Mat reference = seen_by(straight(), 1, 0), image = seen_by(slanted(), 0.7, 30);
  PatchWarp start;
  start.t = slanted().t + Eigen::Vector2d(1.3, -1.1);
  const auto found = align_patch(reference, texture_middle, patch_radius, image, start);
  ASSERT_TRUE(found);
  EXPECT_LT((found->t - slanted().t).norm(), 0.05);
  EXPECT_LT((found->A - slanted().A).norm(), 0.05);
}

TEST(PatchAlignment, RefusesWhatIsNotThere) {
  const cv::Mat reference = seen_by(straight(), 1, 0);
  PatchWarp start;
  start.t = texture_middle;
  EXPECT_TRUE(align_patch(reference, texture_middle, patch_radius, reference, start));
  EXPECT_FALSE(
      align_patch(reference, texture_middle, patch_radius, cv::Mat(120, 120, CV_8UC1, cv::Scalar(90)), start))
      << "plain";
  cv::Mat other(120, 120, CV_8UC1);
  cv::theRNG().state = 3;
  cv::randu(other, 0, 255);
  EXPECT_FALSE(align_patch(reference, texture_middle, patch_radius, other, start)) << "noise";
  EXPECT_FALSE(align_patch(seen_by(straight(), 0.01, 90), texture_middle, patch_radius, reference, start))
      << "no contrast";
  EXPECT_FALSE(align_patch(reference, {4, 60}, patch_radius, reference, start)) << "beyond the rim";
  start.t += Eigen::Vector2d(7, 0);
  const auto far = align_patch(reference, texture_middle, patch_radius, reference, start);
  EXPECT_TRUE(!far || (far->t - start.t).norm() <= PatchAlignmentSettings().farthest);
}

}  // namespace
}  // namespace lcmslam
