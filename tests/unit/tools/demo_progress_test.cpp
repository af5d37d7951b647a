#include "tools/demo/demo_progress.hpp"

#include <gtest/gtest.h>

#include "tools/above_zero.hpp"
#include "tools/time_left.hpp"

namespace lcmslam {
namespace {

TEST(DemoProgress, SaysWhatThoseThatStartWaitFor) {
  StatusBoard board;
  board["surf"].state = status_t::RUNNING;
  board["surf"].detail = "waits for CAMERA";
  EXPECT_EQ(format_start(3, board, 6), "    3 s  starting: 1 of 6 processes");
  board["camera"].state = status_t::STARTING;
  EXPECT_EQ(format_start(3, board, 6), "    3 s  starting: 2 of 6 processes");
  board["camera"].detail = "/dev/video0: No such file or directory";
  EXPECT_EQ(format_start(12, board, 6),
            "   12 s  starting: 2 of 6 processes; camera: /dev/video0: No such file or directory");
}

TEST(AboveZero, RefusesInAFewWords) {
  for (std::string good : {"0.1", "3", "1e300"}) EXPECT_EQ(above_zero()(good), "");
  for (std::string bad : {"0", "-3", "nan", "inf", "three"})
    EXPECT_EQ(above_zero()(bad), bad + " is no number above 0");
}

TEST(TimeLeft, IsNotGuessedFromWhatCameInOneGo) {
  EXPECT_FALSE(time_left(0, 0.04));
  EXPECT_FALSE(time_left(4.9, 0.5));
  EXPECT_FALSE(time_left(60, 0));
  EXPECT_FALSE(time_left(60, 0.02));
  EXPECT_EQ(time_left(6, 0.25), 18.0);
  EXPECT_EQ(time_left(6, 1), 0.0);
}

}  // namespace
}  // namespace lcmslam
