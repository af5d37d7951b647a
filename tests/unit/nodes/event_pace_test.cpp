#include "procs/camera/event_pace.hpp"

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::size_t image = 0, wheels = 1;
constexpr Utime second = 1'000'000, hour = 3600 * second;

class Pace : public ::testing::Test {
 protected:
  /// When it is due, after the first event.
  EventPace::Clock::duration due(std::size_t kind, Utime utime) {
    return pace_.due(kind, utime, start_) - start_;
  }
  const EventPace::Clock::time_point start_ = EventPace::Clock::time_point() + seconds(1000);
  EventPace pace_{1};
};

TEST_F(Pace, KeepsTheIntervals) {
  EXPECT_EQ(due(image, 5 * second), seconds(0));
  EXPECT_EQ(due(wheels, 5 * second - 20'000), milliseconds(-20));
  EXPECT_EQ(due(image, 6 * second), seconds(1));
  EXPECT_EQ(due(image, 15 * second), seconds(10)) << "a pause";
  EXPECT_EQ(pace_.leaps(), 0U);
  EventPace fast(4);
  fast.due(image, 0, start_);
  EXPECT_EQ(fast.due(image, 2 * second, start_) - start_, milliseconds(500));
}

TEST_F(Pace, AClockThatIsSetSilencesNothing) {
  for (const Utime leap : {hour, -hour, 20 * second, -5 * second}) {
    SCOPED_TRACE(leap);
    pace_ = EventPace(1);
    for (const Utime utime : {Utime{0}, second}) {
      due(image, utime);
      due(wheels, utime);
    }
    EXPECT_EQ(due(image, leap + 2 * second), seconds(1)) << "at once";
    EXPECT_EQ(due(wheels, leap + 2 * second), seconds(1));
    EXPECT_EQ(due(image, leap + 3 * second), seconds(2));
    EXPECT_EQ(due(wheels, leap + 4 * second), seconds(3));
    EXPECT_EQ(pace_.leaps(), 1U) << "the wheels' is the same";
  }
}

TEST_F(Pace, WheelsMayHaveAnotherClock) {
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(due(image, i * second), seconds(i));
    EXPECT_EQ(due(wheels, hour + i * second), seconds(i));
  }
  EXPECT_EQ(pace_.leaps(), 1U);
}

TEST_F(Pace, WhatCameLateIsNotMadeUpFor) {
  due(image, 0);
  due(image, second);
  pace_.delay(seconds(3));
  EXPECT_EQ(due(image, 2 * second), seconds(5));
}

}  // namespace
}  // namespace lcmslam
