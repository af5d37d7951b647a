#include <lcmslam/runtime/terminal_colours.hpp>

#include <gtest/gtest.h>
#include <unistd.h>

namespace lcmslam {
namespace {

TEST(TerminalColours, AreForTerminalsThatHaveThemAndUsersWhoWantThem) {
  EXPECT_TRUE(wants_colours(true, nullptr, "xterm"));
  EXPECT_TRUE(wants_colours(true, "", "xterm")) << "an empty NO_COLOR is none";
  EXPECT_FALSE(wants_colours(true, "1", "xterm"));
  EXPECT_FALSE(wants_colours(true, nullptr, "dumb"));
  EXPECT_FALSE(wants_colours(true, nullptr, nullptr));
  EXPECT_FALSE(wants_colours(false, nullptr, "xterm")) << "a file or a pipe";
}

TEST(TerminalColours, AreNotInAPipe) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  EXPECT_FALSE(wants_colours(ends[1]));
  EXPECT_EQ(log_colours(ends[1]), spdlog::color_mode::never);
  close(ends[0]);
  close(ends[1]);
}

TEST(TerminalColours, EndWithTheText) {
  EXPECT_EQ(emphasised("bad", Emphasis::failure, false), "bad");
  const std::string coloured = emphasised("bad", Emphasis::failure, true);
  EXPECT_EQ(coloured.find("\x1b["), 0U);
  EXPECT_NE(coloured.find("bad\x1b[0m"), std::string::npos);
}

}  // namespace
}  // namespace lcmslam
