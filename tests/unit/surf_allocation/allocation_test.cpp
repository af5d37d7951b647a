// A program of its own, because it counts every call of malloc: operator new and OpenCV's matrices too.
#include <gtest/gtest.h>

#include <malloc.h>
#include <atomic>
#include <cerrno>
#include <cstdlib>

#include <lcmslam/surf/surf.hpp>
#include "tests/unit/surf/blob_scene.hpp"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define LCMSLAM_COUNTS_MALLOC

namespace {
std::atomic<int> allocations{0};
}

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  ++allocations;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  ++allocations;
  *memory = __libc_memalign(alignment, size);
  return *memory || size == 0 ? 0 : ENOMEM;
}
}
#endif

namespace lcmslam {
namespace {

TEST(SurfAllocation, NoneAFrameAfterTheFirstOnes) {
#ifndef LCMSLAM_COUNTS_MALLOC
  GTEST_SKIP() << "the sanitizer's malloc cannot be counted";
#else
  {
    const int before = allocations;
    const cv::Mat matrix(100, 100, CV_8U);
    auto* volatile number = new int(3);
    delete number;
    ASSERT_GE(allocations - before, 2) << "the counter does not count";
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
    const int before = allocations;
    for (const cv::Mat& image : images) surf.detectAndCompute(image, mask, keypoints, descriptors);
    EXPECT_EQ(allocations - before, 0) << (extended ? "extended" : "64-D");
    ASSERT_EQ(descriptors.rows, 300);
  }
  cv::setNumThreads(threads);
#endif
}

}  // namespace
}  // namespace lcmslam
