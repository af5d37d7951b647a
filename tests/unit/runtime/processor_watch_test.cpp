#include <lcmslam/runtime/processor_watch.hpp>

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

namespace lcmslam {
namespace {

/// A thread that runs and waits for a processor these shares of the time, looked at each 50 ms.
class ProcessorWatchTest : public ::testing::Test {
 protected:
  void pass(double seconds, double runs, double waits) {
    for (int i = 0; i < std::lround(seconds / 0.05); ++i) {
      now_ += std::chrono::milliseconds(50);
      time_.ran += 0.05 * runs;
      time_.waited += 0.05 * waits;
      watch_.look(time_, now_);
    }
  }
  ProcessorWatch watch_;
  ProcessorWatch::Time now_ = ProcessorWatch::Time(std::chrono::seconds(1000));
  ThreadTime time_;
};

TEST_F(ProcessorWatchTest, IsStarvedWhenOthersHaveTheProcessors) {
  pass(5, 0.3, 0.1);
  EXPECT_FALSE(watch_.is_starved());
  pass(0.5, 0.3, 0.6);
  EXPECT_TRUE(watch_.is_starved()) << "within half a second";
  pass(3, 0.3, 0.6);
  EXPECT_EQ(watch_.stretches(), 1);
  pass(1, 0.3, 0.1);
  EXPECT_FALSE(watch_.is_starved());
  pass(1, 0.3, 0.6);
  EXPECT_EQ(watch_.stretches(), 2);
}

TEST_F(ProcessorWatchTest, IsNotByWhatMakesNothingLate) {
  pass(3, 0.9, 0.8);
  EXPECT_FALSE(watch_.is_starved()) << "it runs more than it waits";
  pass(3, 0.01, 0.2);
  EXPECT_FALSE(watch_.is_starved()) << "a tenth of a second in half a one";
  pass(0.1, 0, 1);
  EXPECT_FALSE(watch_.is_starved()) << "a moment";
}

TEST_F(ProcessorWatchTest, AKernelThatDoesNotCountTellsNothing) {
  pass(3, 0, 0);
  EXPECT_FALSE(watch_.is_starved());
}

// The kernel's figures are in the units that are claimed.
TEST(MainThreadTime, CountsWhatItRan) {
  const ThreadTime before = main_thread_time();
  if (before.ran == 0) GTEST_SKIP() << "this kernel does not count";
  const double begin = thread_cpu_seconds();
  while (thread_cpu_seconds() < begin + 0.1) {
  }
  const ThreadTime after = main_thread_time();
  EXPECT_GT(after.ran - before.ran, 0.09);
  EXPECT_GE(after.waited, before.waited);
}

}  // namespace
}  // namespace lcmslam
