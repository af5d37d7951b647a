#include <lcmslam/surf/smoothing.hpp>

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

TEST(BinomialSmoother, EqualsTheTwoDimensionalSum) {
  const cv::Mat weights = (cv::Mat_<double>(9, 1) << 1, 8, 28, 56, 70, 56, 28, 8, 1);
  Random random(3);
  BinomialSmoother smoother;
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 5), cv::Size(7, 3), cv::Size(67, 41)}) {
    cv::Mat image(size, CV_8UC1);
    for (auto p = image.begin<std::uint8_t>(); p != image.end<std::uint8_t>(); ++p)
      *p = static_cast<std::uint8_t>(random.below(256));
    cv::Mat sums;
    cv::sepFilter2D(image, sums, CV_64F, weights, weights, {-1, -1}, 0, cv::BORDER_REPLICATE);
    const cv::Mat& smooth = smoother.smooth(image);
    ASSERT_EQ(smooth.size(), size);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        ASSERT_EQ(smooth.at<std::uint8_t>(y, x), std::floor(sums.at<double>(y, x) / 65536 + 0.5))
            << x << " " << y << " of " << size;
  }
}

TEST(BinomialSmoother, LeavesConstantImagesAlone) {
  for (const int grey : {0, 1, 128, 255}) {
    const cv::Mat image(40, 30, CV_8UC1, cv::Scalar(grey));
    EXPECT_EQ(cv::norm(BinomialSmoother().smooth(image), image, cv::NORM_INF), 0);
  }
}

TEST(BinomialSmoother, TakesViewsOfLargerImages) {
  cv::Mat image(50, 60, CV_8UC1);
  cv::randu(image, 0, 256);
  const cv::Mat view = image(cv::Rect(7, 9, 31, 23));
  BinomialSmoother of_view, of_copy;
  EXPECT_EQ(cv::norm(of_view.smooth(view), of_copy.smooth(view.clone()), cv::NORM_INF), 0);
}

TEST(SmoothedSize, AndBackAreInverse) {
  for (const float size : {7.f, 10.f, 33.f, 200.f}) {
    EXPECT_GT(smoothed_size(size), size);
    EXPECT_NEAR(unsmoothed_size(smoothed_size(size)), size, 1e-4f * size);
  }
  EXPECT_EQ(unsmoothed_size(3), 1);  // less than smoothing alone would give
}

}  // namespace
}  // namespace lcmslam
