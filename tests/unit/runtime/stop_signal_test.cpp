// In processes of their own, for a stop cannot be taken back.

#include <lcmslam/runtime/stop_signal.hpp>

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>

namespace lcmslam {
namespace {

[[noreturn]] void exit_stopped_by(int signal_number) {
  install_stop_signals(0);
  std::raise(signal_number);
  std::_Exit(stop_requested() ? 7 : 8);
}

TEST(StopSignal, AClosedTerminalAsksToStopAsTheOthersDo) {
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP})
    EXPECT_EXIT(
        {
          std::signal(SIGHUP, SIG_DFL);  // the tests may run under nohup
          exit_stopped_by(signal_number);
        },
        ::testing::ExitedWithCode(7), "");
}

TEST(StopSignal, UnderNohupTheTerminalMayGo) {
  EXPECT_EXIT(
      {
        std::signal(SIGHUP, SIG_IGN);
        exit_stopped_by(SIGHUP);
      },
      ::testing::ExitedWithCode(8), "");
}

}  // namespace
}  // namespace lcmslam
