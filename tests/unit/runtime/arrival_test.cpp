#include <lcmslam/runtime/arrival.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

constexpr Utime newest = 100'000'000, gap = 5'000'000;

TEST(Arrival, ALittleBackIsLateAndMuchIsAnotherRun) {
  EXPECT_EQ(arrival_of(newest + 1, newest, gap), Arrival::next);
  EXPECT_EQ(arrival_of(newest + gap, newest, gap), Arrival::next);
  EXPECT_EQ(arrival_of(newest + gap + 1, newest, gap), Arrival::jumped);
  EXPECT_EQ(arrival_of(newest, newest, gap), Arrival::late);
  EXPECT_EQ(arrival_of(newest - 999'999, newest, gap), Arrival::late);
  EXPECT_EQ(arrival_of(newest - 1'000'000, newest, gap), Arrival::jumped);
}

TEST(Arrival, TheSameTimeAgainIsLateOnlyForThoseWhoSaySo) {
  EXPECT_FALSE(came_late(newest, newest));
  EXPECT_TRUE(came_late_or_twice(newest, newest));
  for (const Utime back : {1, 999'999}) {
    EXPECT_TRUE(came_late(newest - back, newest));
    EXPECT_TRUE(came_late_or_twice(newest - back, newest));
  }
  EXPECT_FALSE(came_late(newest - 1'000'000, newest));
  EXPECT_FALSE(came_late_or_twice(newest - 1'000'000, newest));
  EXPECT_FALSE(came_late(newest + 1, newest));
}

}  // namespace
}  // namespace lcmslam
