// Images of a folder as calibrate reads them.

#include "tools/calibrate/shots.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include <lcmslam/calibration/board_view.hpp>
#include "tests/support/board_shots.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

/// The board before a camera, in a sensor's counts: dark ones, and some pixels that are blinded.
cv::Mat counts_of(const cv::Mat& grey) {
  cv::Mat counts;
  grey.convertTo(counts, CV_16U, 5, 300);
  counts(cv::Rect(0, 0, 8, 4)) = 65535;
  return counts;
}

TEST(Shots, ImagesOf16BitsShowTheBoard) {
  const Board board = testing::large_board();
  const CameraModel camera = testing::drawn_tof_camera(3);
  Random random(5);
  testing::BoardPlaces places;
  places.middle = 0.1, places.near = 0.6, places.far = 0.6, places.tilt = 0.3;
  const cv::Mat grey =
      testing::BoardRenderer(board, camera, {0.5, 3, 4})(places(0, board, camera, random), random);
  const testing::ScratchFolder scratch;
  for (const char* folder : {"amplitude", "alone"})
    std::filesystem::create_directories(scratch.path() / folder);
  cv::imwrite((scratch.path() / "amplitude/a.png").string(), counts_of(grey));
  cv::imwrite((scratch.path() / "alone/a.png").string(), counts_of(grey));
  cv::imwrite((scratch.path() / "alone/b.png").string(), grey);

  ShotInput several, alone;
  several.path = scratch.path().string(), alone.path = (scratch.path() / "alone").string();
  int shots = 0;
  const auto check = [&](const cv::Mat& image) {
    ++shots;
    ASSERT_EQ(image.type(), CV_8UC1);
    double darkest = 0, brightest = 0;
    cv::minMaxLoc(image, &darkest, &brightest);
    EXPECT_LT(darkest, 50);
    EXPECT_GT(brightest, 150);
    EXPECT_TRUE(find_board(image, board));
  };
  read_shots(several, [&](const Shot& shot) { return check(shot.amplitude), true; });
  read_shots(alone, [&](const Shot& shot) {
    check(shot.colour);
    if (shot.name == "b.png") {
      EXPECT_EQ(cv::norm(shot.colour, grey, cv::NORM_INF), 0) << "8 bits stay";
    }
    return true;
  });
  EXPECT_EQ(shots, 3);
}

TEST(Shots, AnImageOf16BitsWithoutContrastStaysDark) {
  const testing::ScratchFolder scratch;
  cv::imwrite((scratch.path() / "a.png").string(), cv::Mat(20, 30, CV_16UC1, cv::Scalar(700)));
  ShotInput input;
  input.path = scratch.path().string();
  cv::Mat image;
  read_shots(input, [&](const Shot& shot) { return image = shot.colour, true; });
  ASSERT_EQ(image.type(), CV_8UC1);
  EXPECT_EQ(cv::countNonZero(image), 0);
}

}  // namespace
}  // namespace lcmslam
