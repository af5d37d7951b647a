// A device's clock that drifts, seen through delays that vary.

#include <lcmslam/cameras/device_clock.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

constexpr Utime period = 33'333;

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
      const Utime host = clock.to_host(device, arrival);
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
    return clock.to_host(device, device + offset) - offset - device;
  };
  Utime device = 0;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(at(device += period, 1'000'000'000), 0);
  for (int i = 0; i < 100; ++i) {  // our clock is set forward by an hour
    const Utime error = at(device += period, 4'600'000'000);
    if (i >= 5) {
      EXPECT_EQ(error, 0) << i;
    }
  }
  for (int i = 0; i < 100; ++i) EXPECT_EQ(at(device += period, 1'000'000'000), 0) << "set back, " << i;
  device = 0;  // reopened
  for (int i = 0; i < 100; ++i) EXPECT_EQ(at(device += period, 1'020'000'000), 0) << i;
}

TEST(DeviceClock, AProcessThatSleptIsNoClockThatWasSet) {
  DeviceClock clock;
  Utime device = 0;
  for (int i = 0; i < 60; ++i, device += period) clock.to_host(device, device + 5'000'000);
  for (int i = 0; i < 3; ++i, device += period)  // three images waited for 1.5 s in a buffer
    EXPECT_EQ(clock.to_host(device, device + 6'500'000), device + 5'000'000);
}

TEST(DeviceClock, TheOtherCameraOfAHeadMayBeALittleEarlier) {
  DeviceClock clock;
  for (Utime device = 0; device < 3'000'000; device += period) {
    EXPECT_EQ(clock.to_host(device + 9'000, device + 5'009'000), device + 5'009'000);
    EXPECT_EQ(clock.to_host(device, device + 5'010'000), device + 5'000'000);
  }
}

TEST(DeviceClock, StampsInAnotherUnitAreNotBelieved) {
  DeviceClock clock;
  Utime arrival = 1'000'000'000;
  for (int i = 0; i < 200; ++i) {
    arrival += period;
    const Utime host = clock.to_host(i * period * 5 / 8, arrival);
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
