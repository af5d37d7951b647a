// The view that carving asks, against the same in OpenCV's words.

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/map_layers/carving_view.hpp>

namespace lcmslam {
namespace {

CameraModel camera_of(const cv::Size& size) {
  CameraModel camera;
  camera.width = size.width, camera.height = size.height;
  camera.fx = camera.fy = 100;
  camera.cx = 0.5 * size.width, camera.cy = 0.5 * size.height;
  return camera;
}

/// Surfaces with single holes, and regions in which most or all pixels are holes; some below zero.
cv::Mat some_depth(const cv::Size& size, std::uint64_t seed) {
  Random random(seed);
  cv::Mat_<float> depth(size);
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u) {
      const double holes = u < size.width / 3 ? 0.1 : u < size.width / 2 ? 0.65 : v < 20 ? 1 : 0.4;
      const auto z = static_cast<float>(1 + 0.01 * u + random.uniform(0, 1));
      depth(v, u) = random.uniform(0, 1) < holes ? 0.0f : random.uniform(0, 1) < 0.01 ? -z : z;
    }
  return depth;
}

class CarvingViewTest : public testing::TestWithParam<cv::Size> {};

TEST_P(CarvingViewTest, NearestDepthsAreThoseOfErosionAndItsHoles) {
  const cv::Size size = GetParam();
  const cv::Mat depth = some_depth(size, 5);
  CarvingView view;
  view.set(some_depth(size, 6), camera_of(size));  // nothing may stay of the image before
  view.set(depth, camera_of(size));
  const cv::Mat nearest = cv::abs(depth), hole = nearest == 0;
  EXPECT_EQ(cv::norm(view.nearest(0), nearest, cv::NORM_INF), 0);
  cv::Mat filled = nearest.clone();
  filled.setTo(1e3f, hole);
  for (int level = 1; level < static_cast<int>(CarvingView::radii.size()); ++level) {
    const int side = 2 * CarvingView::radii[static_cast<std::size_t>(level)] + 1;
    cv::Mat expected, holes;
    cv::erode(filled, expected, cv::Mat::ones(side, side, CV_8U));
    cv::boxFilter(hole, holes, CV_8U, {side, side});
    expected.setTo(0, holes > 255 * 0.65);
    EXPECT_EQ(cv::norm(view.nearest(level), expected, cv::NORM_INF), 0) << "level " << level;
    if (size.area() > 2000) {
      EXPECT_GT(cv::countNonZero(view.nearest(level)), 100);
      EXPECT_GT(cv::countNonZero(view.nearest(level) == 0), 100);
    }
  }
}

TEST_P(CarvingViewTest, ExtremesAreThoseOfTheTilesThatCoverThem) {
  const cv::Size size = GetParam();
  const cv::Mat depth = some_depth(size, 7);
  CarvingView view;
  view.set(depth, camera_of(size));
  const cv::Mat nearest = cv::abs(depth);
  double most = 0;
  cv::minMaxIdx(nearest, nullptr, &most);
  EXPECT_EQ(view.farthest(), static_cast<float>(most));
  for (const auto& [u, v] : {std::pair{0, 0}, {size.width / 2, size.height / 2}, {size.width - 1, 0}}) {
    const Eigen::Vector2i first(u, v), last(size.width - 1, size.height - 1);
    const int left = u / CarvingView::tile * CarvingView::tile,
              top = v / CarvingView::tile * CarvingView::tile;
    double least = 0;
    cv::minMaxIdx(nearest(cv::Rect(left, top, size.width - left, size.height - top)), &least, &most);
    EXPECT_EQ(view.extremes(first, last).least, static_cast<float>(least));
    EXPECT_EQ(view.extremes(first, last).most, static_cast<float>(most));
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, CarvingViewTest,
                         testing::Values(cv::Size(640, 480), cv::Size(176, 144), cv::Size(101, 37),
                                         cv::Size(5, 4)));

}  // namespace
}  // namespace lcmslam
