#include <lcmslam/calibration/board_view.hpp>

#include <gmock/gmock.h>

#include "tests/support/board_shots.hpp"

namespace lcmslam {
namespace {

CameraModel camera() {
  CameraModel c;
  c.width = 640, c.height = 480;
  c.fx = 560, c.fy = 555, c.cx = 322, c.cy = 236;
  c.distortion = {-0.12, 0.05, 0.0005, -0.0003, 0};
  return c;
}

Board board(const std::string& kind) {
  BoardSettings settings;
  settings.kind = kind;
  return Board(settings);
}

class BoardTest : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Kinds, BoardTest, ::testing::Values("charuco", "checkerboard"));

TEST_P(BoardTest, CornersAreFoundToAFractionOfAPixelWhicheverWayUpItIs) {
  const Board b = board(GetParam());
  const CameraModel c = camera();
  const testing::BoardRenderer render(b, c);
  Random random(3);
  for (const double turn : {0.0, M_PI - 0.1, 1.3}) {
    const Eigen::Isometry3d T = testing::held_board(b, c, {330, 230}, 0.42, 0.3, -0.25, turn);
    const auto view = find_board(render(T, random), b);
    ASSERT_TRUE(view) << turn;
    EXPECT_GE(static_cast<int>(view->ids.size()), b.has_markers() ? 40 : b.corners());
    double squares = 0;
    for (std::size_t i = 0; i < view->ids.size(); ++i) {
      const Eigen::Vector2d off = *c.project(T * b.corner(view->ids[i])) - view->pixels[i];
      EXPECT_LT(off.norm(), 0.4) << turn << ", corner " << view->ids[i];
      squares += off.squaredNorm();
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(view->ids.size())), 0.15) << turn;
    const auto pose = board_pose(*view, b, c);
    ASSERT_TRUE(pose);
    EXPECT_LT(distance_between(*pose, T), 0.001);
    EXPECT_LT(angle_between(*pose, T), 0.004);
  }
}

// What tells a corner are its edges, and the more of them the less noise is left: windows reach as far as
// squares.
TEST(BoardTest, CornersInFewPixelsAreFoundByTheWholeOfTheirEdges) {
  const Board b = testing::large_board();
  const CameraModel c = testing::drawn_tof_camera(3);
  const testing::BoardRenderer render(b, c, {0.5, 3, 5});
  Random random(3);
  double squares = 0, count = 0;
  for (int i = 0; i < 12; ++i) {
    testing::BoardPlaces places;
    places.near = 0.85, places.far = 0.7, places.middle = 0.15;
    const Eigen::Isometry3d T = places(i, b, c, random);
    const auto view = find_board(render(T, random), b);
    if (!view) continue;
    for (std::size_t k = 0; k < view->ids.size(); ++k, ++count)
      squares += (*c.project(T * b.corner(view->ids[k])) - view->pixels[k]).squaredNorm();
  }
  ASSERT_GT(count, 300);
  EXPECT_LT(std::sqrt(squares / count), 0.016) << "pixels; 0.066 by gradients";
}

// What hides a corner is no corner.
TEST(BoardTest, ACornerUnderAThumbIsLeftOut) {
  const Board b = board("checkerboard");
  const CameraModel c = camera();
  Random random(5);
  const Eigen::Isometry3d T = testing::held_board(b, c, {330, 230}, 0.42, 0.3, -0.25, 0);
  cv::Mat image = testing::BoardRenderer(b, c)(T, random);
  const int hidden = 20;
  const Eigen::Vector2d corner = *c.project(T * b.corner(hidden));
  cv::circle(image, {static_cast<int>(corner.x()) + 6, static_cast<int>(corner.y())}, 6, {200}, cv::FILLED);
  const auto view = find_board(image, b);
  ASSERT_TRUE(view);
  EXPECT_GT(static_cast<int>(view->ids.size()), b.corners() - 4);
  EXPECT_THAT(view->ids, ::testing::Not(::testing::Contains(hidden)));
}

TEST(BoardTest, OfMarkersAPartIsEnough) {
  const Board b = board("charuco");
  const CameraModel c = camera();
  Random random(4);
  const auto view = find_board(
      testing::BoardRenderer(b, c)(testing::held_board(b, c, {600, 440}, 0.3, 0.1, 0.2, 0), random), b);
  ASSERT_TRUE(view);
  EXPECT_LT(static_cast<int>(view->ids.size()), b.corners() * 2 / 3);
}

TEST(BoardTest, AWallIsNoBoard) {
  cv::Mat wall(480, 640, CV_8UC1, cv::Scalar(120));
  EXPECT_FALSE(find_board(wall, board("charuco")));
  EXPECT_FALSE(find_board(wall, board("checkerboard")));
}

TEST(BoardTest, ABoardThatLooksTheSameWhenTurnedIsRefused) {
  BoardSettings settings;
  settings.columns = 9, settings.rows = 7;
  EXPECT_THROW(Board{settings}, std::invalid_argument);
}

BoardSettings of_size(const char* kind, int columns, int rows) {
  BoardSettings settings;
  settings.kind = kind, settings.columns = columns, settings.rows = rows;
  return settings;
}

TEST(BoardTest, ABoardThatNoViewCouldShowIsRefused) {
  for (const BoardSettings& settings :
       {of_size("charuco", 3, 4), of_size("charuco", 6, 3), of_size("checkerboard", 3, 4)})
    EXPECT_THAT([&] { Board{settings}; },
                ::testing::ThrowsMessage<std::invalid_argument>(::testing::HasSubstr("4 x 5 squares")));
  for (const BoardSettings& settings : {of_size("checkerboard", 3, 8), of_size("checkerboard", 8, 3)})
    EXPECT_THAT([&] { Board{settings}; },
                ::testing::ThrowsMessage<std::invalid_argument>(::testing::HasSubstr("4 or more")));
}

TEST(BoardTest, TheSmallestBoardsAreFound) {
  const CameraModel c = camera();
  Random random(6);
  for (const BoardSettings& settings : {of_size("charuco", 4, 5), of_size("charuco", 3, 8),
                                        of_size("checkerboard", 4, 5), of_size("checkerboard", 5, 4)}) {
    const Board b{settings};
    const Eigen::Isometry3d T = testing::held_board(b, c, {330, 230}, 0.25, 0.2, -0.2, 0);
    const auto view = find_board(testing::BoardRenderer(b, c)(T, random), b);
    ASSERT_TRUE(view) << settings.kind << ' ' << settings.columns;
    EXPECT_EQ(static_cast<int>(view->ids.size()), b.corners());
  }
}

TEST(BoardTest, ThePrintHasItsTrueSize) {
  const std::string svg = board("checkerboard").svg();
  EXPECT_THAT(svg, ::testing::HasSubstr("width=\"275mm\""));  // ten squares of 25 mm and the margin
  EXPECT_THAT(svg, ::testing::HasSubstr("squares of 25 mm"));
}

}  // namespace
}  // namespace lcmslam
