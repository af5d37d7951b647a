#include <lcmslam/rgbd/colour_overlap.hpp>

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include <lcmslam/geometry/random.hpp>
#include "tests/support/vga_camera.hpp"

namespace lcmslam {
namespace {

cv::Mat texture() {
  Random random(2);
  cv::Mat image(700, 1000, CV_8UC3);
  for (auto& pixel : cv::Mat_<cv::Vec3b>(image))
    for (int k = 0; k < 3; ++k) pixel[k] = static_cast<std::uint8_t>(256 * random.uniform());
  cv::GaussianBlur(image, image, {}, 6);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  return image;
}

TEST(ColourOverlap, FindsWhatBothImagesShow) {
  const cv::Mat world = texture();
  const cv::Mat target = world({100, 100, 640, 480});
  const cv::Mat source =
      world({340, 100, 640, 480});  // 240 pixels to the right: three of eight columns are new
  for (const double search : {0., 60.}) {
    SCOPED_TRACE(search);
    ColourOverlapSettings settings;
    settings.search = search;
    const ImageOverlap overlap = colour_overlap(source, target, settings, {230, 5});
    ASSERT_EQ(overlap.segments().size(), 48U);
    for (const Segment& segment : overlap.segments()) {
      const bool shown = segment.area.x + segment.area.width + 240 <= 640;
      EXPECT_EQ(segment.state, shown ? SegmentState::overlapping : SegmentState::outside) << segment.area;
      if (!shown) continue;
      EXPECT_GT(segment.coefficient, 0.9);
      const double x = segment.area.x + 0.5 * segment.area.width + 240,
                   y = segment.area.y + 0.5 * segment.area.height;
      EXPECT_NEAR(segment.found.x, x, 4);
      EXPECT_NEAR(segment.found.y, y, 4);
    }
    EXPECT_DOUBLE_EQ(overlap.overlap().value(), 5 / 8.);
  }
}

TEST(ColourOverlap, APlainSegmentIsUnknownAndItsPointsStay) {
  const cv::Mat world = texture();
  cv::Mat source = world({0, 0, 640, 480}).clone();
  source({0, 0, 160, 480}).setTo(cv::Scalar::all(90));
  const ImageOverlap overlap = colour_overlap(source, world({360, 220, 640, 480}));
  EXPECT_EQ(overlap.at(10, 10)->state, SegmentState::unknown);
  EXPECT_EQ(overlap.at(100, 470)->state, SegmentState::unknown);
  EXPECT_EQ(overlap.at(200, 10)->state, SegmentState::outside);
  EXPECT_EQ(overlap.at(-1, 10), nullptr);
  EXPECT_EQ(overlap.at(10, 480), nullptr);
  Cloud cloud;
  cloud.points = {{-0.55f, 0, 1}, {0, 0, 1}, {0, 0, -1}};  // pixels 31, 320, none
  EXPECT_EQ(overlapping_points(cloud, overlap, vga_camera()).size(), 1U);

  const cv::Mat plain(480, 640, CV_8UC3, cv::Scalar::all(7));
  EXPECT_FALSE(colour_overlap(plain, plain).overlap());
}

TEST(ColourOverlap, RefusesImagesThatDoNotFit) {
  const cv::Mat image(48, 64, CV_8UC1, cv::Scalar(1));
  EXPECT_THROW(colour_overlap(image, cv::Mat()), std::invalid_argument);
  EXPECT_THROW(colour_overlap(image, cv::Mat(48, 64, CV_8UC3)), std::invalid_argument);
  EXPECT_THROW(colour_overlap(cv::Mat(48, 64, CV_32FC1), cv::Mat(48, 64, CV_32FC1)), std::invalid_argument);
  ColourOverlapSettings settings;
  settings.scale = 0;
  EXPECT_THROW(colour_overlap(image, image, settings), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
