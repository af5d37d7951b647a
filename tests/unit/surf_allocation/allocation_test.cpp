#include <gtest/gtest.h>

#include <lcmslam/surf/surf.hpp>
#include "tests/unit/surf/blob_scene.hpp"
#include "tests/unit/surf_allocation/malloc_count.hpp"

namespace lcmslam {
namespace {

TEST(SurfAllocation, NoneAFrameAfterTheFirstOnes) {
  if (testing::malloc_calls() == 0) GTEST_SKIP() << "the sanitizer's malloc cannot be counted";
  {
    const long before = testing::malloc_calls();
    const cv::Mat matrix(100, 100, CV_8U);
    auto* volatile number = new int(3);
    delete number;
    ASSERT_GE(testing::malloc_calls() - before, 2) << "the counter does not count";
  }
  // What the threads' scheduler takes for its tasks is not SURF's: one thread.
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  std::vector<cv::Mat> images;
  for (int i = 0; i < 5; ++i)
    images.push_back(
        test::random_scene(20 + std::uint64_t(i), 300, 1500).draw(640, 480, {1, 0.1 * i, 320, 240}));
  for (const bool extended : {false, true}) {
    SurfSettings settings;
    settings.hessian_threshold = 1;
    settings.extended = extended;
    settings.budget.max_features = 300;
    Surf surf(settings);
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    const cv::Mat mask(480, 640, CV_8UC1, cv::Scalar(1));
    for (const cv::Mat& image : images) surf.detectAndCompute(image, mask, keypoints, descriptors);
    ASSERT_EQ(keypoints.size(), 300u);
    const long before = testing::malloc_calls();
    for (const cv::Mat& image : images) surf.detectAndCompute(image, mask, keypoints, descriptors);
    EXPECT_EQ(testing::malloc_calls() - before, 0) << (extended ? "extended" : "64-D");
    ASSERT_EQ(descriptors.rows, 300);
  }
  cv::setNumThreads(threads);
}

}  // namespace
}  // namespace lcmslam
