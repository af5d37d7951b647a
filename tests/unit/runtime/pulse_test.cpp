#include <lcmslam/runtime/pulse.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

using namespace std::chrono_literals;

Pulse::Time beaten(Pulse& pulse, int times, std::chrono::milliseconds period, Pulse::Time now = {}) {
  for (int i = 0; i < times; ++i) pulse.beat(now += period);
  return now;
}

TEST(Pulse, FramesThatStopAreMissedWithinASecond) {
  Pulse pulse;
  const Pulse::Time now = beaten(pulse, 30, 100ms);
  EXPECT_FALSE(pulse.stopped(now + 400ms));
  EXPECT_TRUE(pulse.stopped(now + 700ms));
}

TEST(Pulse, SlowMessagesMayTakeTheirTime) {
  Pulse pulse;
  const Pulse::Time now = beaten(pulse, 30, 1000ms);
  EXPECT_FALSE(pulse.stopped(now + 4000ms));
  EXPECT_TRUE(pulse.stopped(now + 6000ms));
}

TEST(Pulse, NothingIsMissedThatNeverCameRegularly) {
  Pulse pulse;
  EXPECT_FALSE(pulse.stopped(Pulse::Time() + 1h));
  const Pulse::Time now = beaten(pulse, 5, 100ms);
  EXPECT_FALSE(pulse.stopped(now + 1h));
}

TEST(Pulse, APauseDoesNotMakeItPatient) {
  Pulse pulse;
  Pulse::Time now = beaten(pulse, 30, 100ms);
  now = beaten(pulse, 1, 60'000ms, now);
  EXPECT_FALSE(pulse.stopped(now + 400ms));
  EXPECT_TRUE(pulse.stopped(now + 700ms));
}

TEST(Pulse, WhatHasBecomeSlowerIsNotMissedForEver) {
  Pulse pulse;
  const Pulse::Time slower = beaten(pulse, 30, 33ms);
  EXPECT_TRUE(pulse.stopped(slower + 900ms));
  const Pulse::Time now = beaten(pulse, 30, 1000ms, slower);
  EXPECT_FALSE(pulse.stopped(now + 4000ms));
  EXPECT_TRUE(pulse.stopped(now + 6000ms));
}

}  // namespace
}  // namespace lcmslam
