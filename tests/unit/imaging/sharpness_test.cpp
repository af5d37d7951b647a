#include <lcmslam/imaging/sharpness.hpp>

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

cv::Mat texture(int width, int height) {
  Random random(1);
  cv::Mat image(height, width, CV_8UC1);
  for (auto& pixel : cv::Mat_<std::uint8_t>(image)) pixel = static_cast<std::uint8_t>(256 * random.uniform());
  cv::GaussianBlur(image, image, {}, 1.5);
  return image;
}

TEST(Sharpness, IsTheMeanStepFromPixelToPixel) {
  cv::Mat ramp(9, 20, CV_8UC1);
  for (int y = 0; y < ramp.rows; ++y)
    for (int x = 0; x < ramp.cols; ++x) ramp.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(7 * x);
  EXPECT_FLOAT_EQ(sharpness(ramp), 7.f);
  EXPECT_EQ(sharpness(cv::Mat(4, 4, CV_8UC1, cv::Scalar(9))), 0.f);
  EXPECT_EQ(sharpness(cv::Mat()), 0.f);
  EXPECT_EQ(sharpness(cv::Mat(5, 1, CV_8UC1, cv::Scalar(9))), 0.f);
}

TEST(Sharpness, FallsWithMotionBlur) {
  const cv::Mat sharp = texture(320, 240);
  float last = sharpness(sharp);
  for (const int length : {3, 7, 15}) {
    cv::Mat blurred;
    cv::blur(sharp, blurred, {length, 1});
    EXPECT_LT(sharpness(blurred), last) << length;
    last = sharpness(blurred);
  }
}

TEST(SharpnessWatch, NoticesABlurredImageAndNotASofterScene) {
  SharpnessWatch watch;
  for (int i = 0; i < 30; ++i) EXPECT_FALSE(watch.observe(8.f));
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(watch.observe(3.f)) << "a shake of 20 images";
  EXPECT_FALSE(watch.observe(8.f));
  for (float value = 8; value > 2; value *= 0.99f)
    EXPECT_FALSE(watch.observe(value));  // a plainer wall comes
}

TEST(SharpnessWatch, KnowsASharpImageAfterASecondOfBlur) {
  SharpnessWatch watch;
  for (int i = 0; i < 30; ++i) EXPECT_FALSE(watch.observe(10));
  for (int i = 0; i < 40; ++i) EXPECT_TRUE(watch.observe(5)) << i;
  EXPECT_GT(watch.usual(), 8.5);
  EXPECT_FALSE(watch.observe(10));
}

}  // namespace
}  // namespace lcmslam
