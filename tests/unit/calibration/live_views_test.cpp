#include "tools/calibrate/live_views.hpp"

#include <gmock/gmock.h>

#include "tests/support/board_shots.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

/// What a ToF camera's user is told, and whether it is the end.
struct Told {
  std::string text;
  bool enough = false;

  Told(std::size_t count, double noise, const WantedRanges& ranges = {}) {
    const Board board = testing::large_board();
    const CameraModel camera = testing::drawn_tof_camera(3);
    auto views = testing::exact_views(board, camera, 30, 3, noise);
    views.resize(count);
    ::testing::internal::CaptureStdout();
    enough = tell_whether_enough(views, board, {camera.width, camera.height}, {}, ranges);
    text = ::testing::internal::GetCapturedStdout();
  }
};

TEST(LiveViews, EndWhenTheFocalLengthIsSureEnough) {
  const Told good(30, 0.01);
  EXPECT_TRUE(good.enough);
  EXPECT_THAT(good.text, HasSubstr("30 views; enough"));
  const Told rough(30, 0.15);
  EXPECT_FALSE(rough.enough);
  EXPECT_THAT(rough.text, HasSubstr("is wanted"));
  EXPECT_FALSE(Told(3, 0.01).enough);
  EXPECT_THAT(Told(5, 0.01).text, HasSubstr("only 5 views"));
}

TEST(LiveViews, OfRangesEndWhenTheBoardWasNearAndFar) {
  const Told near_only(30, 0.01, {1.0, 2.4});
  EXPECT_FALSE(near_only.enough);
  EXPECT_THAT(near_only.text, HasSubstr("hold it from 1.0 to 2.4 m"));
  EXPECT_TRUE(Told(30, 0.01, {1.0, 1.2}).enough);
}

}  // namespace
}  // namespace lcmslam
