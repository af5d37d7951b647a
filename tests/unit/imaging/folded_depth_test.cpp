#include <lcmslam/imaging/folded_depth.hpp>

#include <gtest/gtest.h>

#include <cmath>

namespace lcmslam {
namespace {

constexpr double turn = 7.5;  // m

RgbdCalibration phase_camera() {
  RgbdCalibration c;
  c.depth.width = 176;
  c.depth.height = 144;
  c.depth.fx = c.depth.fy = 100;
  c.depth.cx = 87.5;
  c.depth.cy = 71.5;
  c.depth_noise = {0, 0, 0, 0.001};
  c.depth_max = turn;
  return c;
}

/// What such a camera says of a surface at `range`.
struct Said {
  std::uint16_t depth;     // mm
  std::uint8_t amplitude;  // of 255, by the range measured
};

Said said_of(double range, double reflectivity, double stretch = 1) {
  const double measured = std::fmod(range, turn);
  return {static_cast<std::uint16_t>(std::lround(1000 * measured / stretch)),
          static_cast<std::uint8_t>(std::lround(255 * reflectivity * std::pow(measured / range, 2)))};
}

/// Whether a pixel keeps its depth.
bool stays(const RgbdCalibration& c, const Said& said, const cv::Point& pixel = {88, 72}) {
  cv::Mat depth(c.depth.height, c.depth.width, CV_16UC1, cv::Scalar(0));
  cv::Mat amplitude(depth.size(), CV_8UC1, cv::Scalar(0));
  depth.at<std::uint16_t>(pixel) = said.depth;
  amplitude.at<std::uint8_t>(pixel) = said.amplitude;
  const FoldedDepthFilter filter(c);
  filter(depth, amplitude);
  return depth.at<std::uint16_t>(pixel) != 0;
}

TEST(FoldedDepth, NothingThatIsFoldedStays) {
  for (double range = turn + 0.3; range < 2 * turn; range += 0.1)
    for (const double reflectivity : {0.2, 0.5, 0.9}) {
      const Said said = said_of(range, reflectivity);
      EXPECT_FALSE(stays(phase_camera(), said)) << range << " m, measured " << said.depth << " mm";
    }
}

TEST(FoldedDepth, SurfacesWithinATurnStayUnlessTheyAreDarkForTheirRange) {
  for (double range = 0.4; range < turn; range += 0.1)
    EXPECT_TRUE(stays(phase_camera(), said_of(range, 0.3))) << range << " m";
  EXPECT_TRUE(stays(phase_camera(), said_of(2, 0.06)));   // (2 / 9.5)^2 is 0.044
  EXPECT_FALSE(stays(phase_camera(), said_of(5, 0.06)));  // (5 / 12.5)^2 is 0.16: white at 12.5 m looks so
}

// In a corner of the image a range is half as long again as the depth.
TEST(FoldedDepth, TheRangeFoldsAndNotTheDepth) {
  const RgbdCalibration c = phase_camera();
  const cv::Point corner(0, 0);
  const double stretch = c.depth.ray({0, 0}).norm();
  ASSERT_GT(stretch, 1.4);
  for (double range = turn + 0.6; range < 2 * turn; range += 0.1)
    EXPECT_FALSE(stays(c, said_of(range, 0.9, stretch), corner)) << range << " m";
}

TEST(FoldedDepth, CamerasThatDoNotFoldKeepAll) {
  const Said folded = said_of(9.5, 0.5);
  RgbdCalibration structured_light = phase_camera();
  structured_light.depth_noise.amplitude = 0;
  EXPECT_TRUE(stays(structured_light, folded));
  cv::Mat depth(144, 176, CV_16UC1, cv::Scalar(folded.depth));
  const FoldedDepthFilter filter(phase_camera());
  filter(depth, cv::Mat());
  EXPECT_EQ(cv::countNonZero(depth), 144 * 176);
}

TEST(FoldedDepth, ImagesOfOtherSizesAreRefused) {
  const FoldedDepthFilter filter(phase_camera());
  cv::Mat depth(144, 176, CV_16UC1, cv::Scalar(1000)), small(72, 88, CV_16UC1, cv::Scalar(1000));
  EXPECT_THROW(filter(depth, cv::Mat(72, 88, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW(filter(small, cv::Mat(72, 88, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW(filter(depth, cv::Mat(144, 176, CV_16UC1)), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
