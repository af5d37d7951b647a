#include <gtest/gtest.h>

#include <lcmslam/imaging/constant_depth.hpp>

namespace lcmslam {
namespace {

cv::Mat depth_of(int millimetres) {
  return cv::Mat(60, 80, CV_16UC1, cv::Scalar(millimetres));
}

TEST(ConstantDepth, IsOneValueWhateverItIs) {
  for (const int value : {1, 2000, 65535}) EXPECT_TRUE(is_constant_depth(depth_of(value))) << value;
  cv::Mat with_holes = depth_of(2000);
  with_holes.rowRange(0, 20).setTo(0);
  EXPECT_TRUE(is_constant_depth(with_holes));
}

TEST(ConstantDepth, IsNoWallThatASensorMeasures) {
  cv::Mat wall = depth_of(2000);
  wall.colRange(40, 80).setTo(2001);  // quantised
  EXPECT_FALSE(is_constant_depth(wall));
  EXPECT_FALSE(is_constant_depth(depth_of(0))) << "which says itself that it is nothing";
  cv::Mat few = depth_of(0);
  few.at<std::uint16_t>(30, 40) = 900;
  EXPECT_FALSE(is_constant_depth(few));
}

}  // namespace
}  // namespace lcmslam
