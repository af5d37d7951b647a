// A device's clock that drifts, seen through delays that vary.

#include <lcmslam/cameras/device_clock.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

constexpr Utime period = 33'333;

/// A wall clock that nobody sets.
HostTime unset(Utime arrival) {
  return {arrival, arrival - 900'000'000};
}

/// Milliseconds of delay: 4 at least, 7 more on average, now and then 80.
double draw_delay(Random& random) {
  const double usual = 4 - 7 * std::log(1 - random.uniform(0, 0.999));
  return random.uniform(0, 1) < 0.02 ? 80 : usual;
}

TEST(DeviceClock, GivesTheTimeAtWhichAnImageWasTaken) {
  for (const double drift : {-50e-6, 0.0, 50e-6}) {
    Random random(7);
    DeviceClock clock;
    Utime last = 0;
    for (int i = 0; i < 5000; ++i) {  // nearly three minutes
      const double taken = 1e15 + 1.0 * i * period;
      const auto device = static_cast<Utime>(123'456 + (1 + drift) * i * period);
      const Utime arrival = static_cast<Utime>(taken + 1000 * draw_delay(random));
      const Utime host = clock.to_host(device, unset(arrival));
      ASSERT_GT(host, last);
      ASSERT_LE(host, arrival);
      last = host;
      if (i < 100) continue;
      // 4 ms are of every delay and cannot be known; 2 ms for the drift over two windows and rare short
      // delays.
      ASSERT_NEAR(static_cast<double>(host), taken + 5000, 2000) << i << ", drift " << drift;
    }
    EXPECT_TRUE(clock.believed());
  }
}

TEST(DeviceClock, FollowsAClockThatIsSetAndADeviceThatBeginsAnew) {
  DeviceClock clock;
  const auto at = [&](Utime device, Utime offset) {
    return clock.to_host(device, {device + offset, 77'000'000 + device}) - offset - device;
  };
  Utime device = 0;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(at(device += period, 1'000'000'000), 0);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(at(device += period, 4'600'000'000), 0) << "set forward, " << i;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(at(device += period, 1'000'000'000), 0) << "set back, " << i;
  device = 0;  // reopened
  for (int i = 0; i < 100; ++i) EXPECT_EQ(at(device += period, 1'020'000'000), 0) << i;
}

/// After a minute our clock is set by `step` (us).
class ClockThatIsSet : public ::testing::TestWithParam<Utime> {};

TEST_P(ClockThatIsSet, IsFollowedAtOnceOrAtAGentlePace) {
  const Utime step = GetParam();
  Random random(7);
  DeviceClock clock;
  Utime last = 0;
  for (int i = 0; i < 3600; ++i) {
    const Utime since = i - 1800, taken = 1'000'000'000 + i * period, set = since < 0 ? 0 : step;
    const Utime arrival = taken + static_cast<Utime>(1000 * random.uniform(2, 9));
    const Utime host = clock.to_host(123'456 + i * period, {arrival + set, arrival - 77'000'000});
    EXPECT_TRUE(clock.believed()) << i;
    if (since != 0 || step > -1'000'000) {
      ASSERT_GE(host - last, period / 4) << i;
    }
    last = host;
    const bool catches_up = step < 0 && step > -1'000'000 && since >= 0 && since * period < -3 * step / 2;
    if (i > 100 && !catches_up) {
      ASSERT_NEAR(static_cast<double>(host - set - taken), 4500, 2500) << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(BySteps, ClockThatIsSet,
                         ::testing::Values(-3'600'000'000, -10'000'000, -900'000, -400'000, -60'000, 60'000,
                                           900'000, 10'000'000, 3'600'000'000));

TEST(DeviceClock, BothCamerasOfAHeadFollowAClockThatIsSetBack) {
  DeviceClock clock;
  for (int i = 0; i < 300; ++i) {
    const Utime device = i * period, set = i < 100 ? 0 : -400'000;
    const HostTime arrival{1'000'000'000 + device + set, device};
    const Utime colour = clock.to_host(device + 9'000, arrival), depth = clock.to_host(device, arrival);
    EXPECT_EQ(colour - depth, 9'000) << i << ": or they are no pair any more";
  }
}

TEST(DeviceClock, StampsDoNotTrembleAsReadingsOfClocksDo) {
  DeviceClock clock;
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(clock.to_host(i * period, {1'000'000'000 + i * period + i % 3, i * period}),
              1'000'000'000 + i * period);
}

TEST(DeviceClock, ADeviceThatStoodStillIsFollowed) {
  DeviceClock clock;
  Utime device = 0;
  for (int i = 0; i < 60; ++i, device += period) clock.to_host(device, unset(device + 1'000'000'000));
  for (int i = 0; i < 60; ++i, device += period) {
    const Utime host = clock.to_host(device, unset(device + 1'003'000'000));
    if (i >= 5) {
      EXPECT_EQ(host, device + 1'003'000'000) << i;
    }
  }
}

TEST(DeviceClock, AProcessThatSleptIsNoClockThatWasSet) {
  DeviceClock clock;
  Utime device = 0;
  for (int i = 0; i < 60; ++i, device += period) clock.to_host(device, unset(device + 5'000'000));
  for (int i = 0; i < 3; ++i, device += period)  // three images waited for 1.5 s in a buffer
    EXPECT_EQ(clock.to_host(device, unset(device + 6'500'000)), device + 5'000'000);
}

TEST(DeviceClock, TheOtherCameraOfAHeadMayBeALittleEarlier) {
  DeviceClock clock;
  for (Utime device = 0; device < 3'000'000; device += period) {
    EXPECT_EQ(clock.to_host(device + 9'000, unset(device + 5'009'000)), device + 5'009'000);
    EXPECT_EQ(clock.to_host(device, unset(device + 5'010'000)), device + 5'000'000);
  }
}

TEST(DeviceClock, StampsInAnotherUnitAreNotBelieved) {
  DeviceClock clock;
  Utime arrival = 1'000'000'000;
  for (int i = 0; i < 200; ++i) {
    arrival += period;
    const Utime host = clock.to_host(i * period * 5 / 8, unset(arrival));
    if (i > 120) {
      EXPECT_EQ(host, arrival);
    }
  }
  EXPECT_FALSE(clock.believed());
}

TEST(UnrolledCounter, GoesOnWhereThirtyTwoBitsEnd) {
  UnrolledCounter unroll;
  EXPECT_EQ(unroll(0xfffffff0U), 0xfffffff0LL);
  EXPECT_EQ(unroll(0x00000010U), 0x100000010LL);
  EXPECT_EQ(unroll(0x00000008U), 0x100000008LL) << "a step back is one";
}

}  // namespace
}  // namespace lcmslam
