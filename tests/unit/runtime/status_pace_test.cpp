#include <lcmslam/runtime/status_pace.hpp>

#include <gtest/gtest.h>

#include <functional>

namespace lcmslam {
namespace {

/// A process that is asked every 50 ms, at times that the test chooses.
class StatusPaceTest : public ::testing::Test {
 protected:
  bool due(double seconds) {
    const auto since =
        std::chrono::duration_cast<StatusPace::Time::duration>(std::chrono::duration<double>(1000 + seconds));
    return pace_.due(report_, refused_, StatusPace::Time(since));
  }
  /// How often it is told from one time to before another, while `meanwhile` happens before each look.
  int told(
      double from, double to, const std::function<void()>& meanwhile = [] {}) {
    int count = 0;
    for (int i = 0; from + 0.05 * i < to - 1e-9; ++i) {
      meanwhile();
      count += due(from + 0.05 * i);
    }
    return count;
  }

  StatusPace pace_;
  NodeReport report_;
  std::int64_t refused_ = 0;
};

TEST_F(StatusPaceTest, AtOnceAndThenEachSecond) {
  EXPECT_TRUE(due(0));
  EXPECT_EQ(told(0.05, 1), 0);
  EXPECT_EQ(told(1, 5), 4);
}

TEST_F(StatusPaceTest, AnotherStateIsToldAtOnce) {
  due(0);
  report_.state = 3;
  EXPECT_TRUE(due(0.05));
  EXPECT_EQ(told(0.1, 1), 0) << "once";
}

TEST_F(StatusPaceTest, OtherWordsAreToldSoonAndFiveTimesASecondAtMost) {
  due(0);
  report_.detail = "no image";
  EXPECT_EQ(told(0.05, 0.2), 0);
  EXPECT_TRUE(due(0.2));
  EXPECT_LE(told(0.25, 10.25, [&] { report_.detail += "."; }), 50);
}

TEST_F(StatusPaceTest, WhatWasRefusedIsToldSoon) {
  EXPECT_EQ(told(0, 4.3), 5);
  ++refused_;
  EXPECT_TRUE(due(4.3));
  EXPECT_EQ(told(4.35, 5.3), 0) << "once";
  EXPECT_TRUE(due(5.3));
  ++refused_;
  EXPECT_EQ(told(5.35, 5.5), 0);
  EXPECT_TRUE(due(5.5));
}

TEST_F(StatusPaceTest, WhoSendsOnAndOnIsToldOfTwiceASecond) {
  due(0);
  const int reports = told(0.05, 10.05, [&] { ++refused_; });
  EXPECT_GE(reports, 20);
  EXPECT_LE(reports, 21);
}

}  // namespace
}  // namespace lcmslam
