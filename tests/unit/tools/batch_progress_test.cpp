#include "tools/batch/batch_progress.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace lcmslam {
namespace {

TEST(BatchProgress, SaysWhatIsDoneAndHowLongTheRestTakes) {
  EXPECT_EQ(format_progress(12, 30, 120), "   12 s  mapping  frame 30/120  36 s left");
  EXPECT_EQ(format_progress(3, 0, 120), "    3 s  mapping  frame 0/120");
  EXPECT_EQ(format_progress(50, 120, 120), "   50 s  finishing  frame 120/120  0 s left");
}

TEST(BatchProgress, WithoutATerminalALineNowAndThen) {
  std::ostringstream out;
  ProgressLine line(out, false);
  for (int tenths = 1; tenths <= 250; ++tenths) line.show(0.1 * tenths, tenths, 500);
  line.clear();
  EXPECT_EQ(out.str(),
            "   10 s  mapping  frame 100/500  40 s left\n   20 s  mapping  frame 200/500  30 s left\n");
}

TEST(BatchProgress, InATerminalALineThatOverwritesItself) {
  std::ostringstream out;
  ProgressLine line(out, true);
  for (int tenths = 1; tenths <= 25; ++tenths) line.show(0.1 * tenths, tenths, 50);
  EXPECT_EQ(out.str(),
            "\r\x1b[K    1 s  mapping  frame 10/50  4 s left\r\x1b[K    2 s  mapping  frame 20/50  3 s left");
}

}  // namespace
}  // namespace lcmslam
