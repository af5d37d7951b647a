#include "tools/log/lockstep.hpp"

#include <gmock/gmock.h>

#include "tools/log/play_order.hpp"
#include "tools/log/play_pace.hpp"

namespace lcmslam {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Time = Lockstep::Time;

const Time start = Time() + std::chrono::hours(1);

TEST(Lockstep, WaitsForAllChannels) {
  Lockstep lockstep({"A", "B"}, seconds(5));
  EXPECT_TRUE(lockstep.ready(start));  // nothing was sent
  lockstep.sent({1'000'000}, start);
  EXPECT_FALSE(lockstep.ready(start + seconds(4)));
  lockstep.answered("A", 1'000'000);
  EXPECT_FALSE(lockstep.ready(start + seconds(4)));
  lockstep.answered("C", 1'000'000);  // nobody asked
  EXPECT_FALSE(lockstep.ready(start + seconds(4)));
  lockstep.answered("B", 1'000'000);
  EXPECT_TRUE(lockstep.ready(start));
  EXPECT_EQ(lockstep.answered_by_all(), 1);
  EXPECT_EQ(lockstep.counts().at("A").given_up, 0);
}

/// ICP's poses carry the depth image's time, up to half a frame and more from the colour image's.
TEST(Lockstep, AnswerBelongsToTheFrameWhoseImagesItIsNearest) {
  for (const Utime depth_after : {-20'000, -5'000, 0, 15'000, 25'000}) {
    SCOPED_TRACE(depth_after);
    Lockstep lockstep({"ICP_POSE"}, seconds(5));
    const auto frame = [&](int i) { return 10'000'000 + 33'333 * i; };
    for (int i = 0; i < 50; ++i) {
      lockstep.sent({frame(i), frame(i) + depth_after}, start);
      if (i > 0) lockstep.answered("ICP_POSE", frame(i - 1) + depth_after);  // again, late
      EXPECT_FALSE(lockstep.ready(start)) << i;
      lockstep.answered("ICP_POSE", frame(i) + depth_after);
      EXPECT_TRUE(lockstep.ready(start)) << i;
    }
    EXPECT_EQ(lockstep.answered_by_all(), 50);
  }
}

TEST(Lockstep, GivesAFrameUpAfterItsPatience) {
  Lockstep lockstep({"A"}, seconds(5));
  lockstep.sent({1'000'000}, start);
  EXPECT_EQ(lockstep.deadline(), start + seconds(5));
  EXPECT_FALSE(lockstep.ready(start + seconds(5) - milliseconds(1)));
  EXPECT_TRUE(lockstep.ready(start + seconds(5)));
  EXPECT_TRUE(lockstep.ready(start));  // it stays given up
  EXPECT_EQ(lockstep.counts().at("A").given_up, 1);
  EXPECT_EQ(lockstep.answered_by_all(), 0);
  lockstep.sent({1'100'000}, start);
  lockstep.answered("A", 1'000'000);  // late: not this frame
  EXPECT_FALSE(lockstep.ready(start));
  lockstep.answered("A", 1'100'000);
  EXPECT_TRUE(lockstep.ready(start));
}

TEST(Lockstep, OneThatNeverAnswersDoesNotHoldUpTheOthers) {
  Lockstep lockstep({"A", "B"}, seconds(5));
  Time now = start;
  int waits = 0;
  const auto play = [&](Utime utime, bool b_answers) {
    lockstep.sent({utime}, now);
    lockstep.answered("A", utime);
    if (b_answers) lockstep.answered("B", utime);
    if (lockstep.ready(now)) return;
    ++waits;
    now += seconds(5);
    EXPECT_TRUE(lockstep.ready(now));
  };
  Utime utime = 0;
  for (int i = 0; i < 20; ++i) play(utime += 100'000, false);
  EXPECT_EQ(waits, 3);
  EXPECT_TRUE(lockstep.counts().at("B").silent);
  EXPECT_EQ(lockstep.counts().at("B").given_up, 20);
  play(utime += 100'000, true);  // it is back
  EXPECT_FALSE(lockstep.counts().at("B").silent);
  play(utime += 100'000, false);
  EXPECT_EQ(waits, 4);
}

TEST(Lockstep, TheOnlyOneIsAlwaysWaitedFor) {
  Lockstep lockstep({"A"}, seconds(1));
  for (int i = 0; i < 10; ++i) {
    lockstep.sent({100'000 * i}, start);
    EXPECT_FALSE(lockstep.ready(start)) << i;
    EXPECT_TRUE(lockstep.ready(start + seconds(1))) << i;
  }
  EXPECT_EQ(lockstep.counts().at("A").given_up, 10);
}

TEST(Lockstep, LateAnswersOfAnotherPassDoNotCount) {
  Lockstep lockstep({"A"}, seconds(5));
  lockstep.sent({60'000'000}, start);
  lockstep.ready(start + seconds(5));
  lockstep.restart();
  lockstep.sent({1'000'000}, start);
  lockstep.answered("A", 60'000'000);
  EXPECT_FALSE(lockstep.ready(start));
  lockstep.answered("A", 1'000'000);
  EXPECT_TRUE(lockstep.ready(start));
}

/// With visual odometry a mapper can answer a frame only when the next one has gone out.
TEST(Lockstep, SomeFramesMayBeInFlight) {
  Lockstep lockstep({"A"}, seconds(5), 2);
  const auto frame = [](int i) { return 1'000'000 + 33'333 * i; };
  lockstep.sent({frame(0)}, start);
  for (int i = 1; i < 40; ++i) {
    EXPECT_TRUE(lockstep.ready(start)) << i;
    lockstep.sent({frame(i)}, start);
    EXPECT_FALSE(lockstep.ready(start)) << i;
    lockstep.answered("A", frame(i - 1));
  }
  EXPECT_TRUE(lockstep.ready(start));
  EXPECT_FALSE(lockstep.done(start));
  EXPECT_TRUE(lockstep.done(start + seconds(5)));
  EXPECT_EQ(lockstep.answered_by_all(), 39);
  EXPECT_EQ(lockstep.counts().at("A").given_up, 1);
}

PlayEvent event(const std::string& channel, Utime logged, Utime utime, std::vector<Utime> frame = {}) {
  PlayEvent e;
  e.event.channel = channel;
  e.event.timestamp = logged;
  e.utime = utime;
  e.frame = std::move(frame);
  return e;
}

std::vector<std::string> order(std::vector<PlayEvent> events, const std::string& readings = "ENCODERS") {
  std::size_t at = 0;
  const auto source = [&]() -> std::optional<PlayEvent> {
    if (at == events.size()) return std::nullopt;
    return events[at++];
  };
  LockstepOrder order(source, readings);
  std::vector<std::string> result;
  while (const auto e = order.next()) result.push_back(e->event.channel[0] + std::to_string(e->utime / 1000));
  return result;
}

using ::testing::ElementsAre;

TEST(LockstepOrder, KeepsTheLogsOrderWhereWheelsComeInTime) {
  EXPECT_THAT(order({event("ENCODERS", 0, 0), event("CAMERA", 10'000, 10'000, {10'000}),
                     event("TRUTH", 12'000, 12'000), event("ENCODERS", 20'000, 20'000),
                     event("CAMERA", 43'000, 43'000, {43'000})}),
              ElementsAre("E0", "C10", "T12", "E20", "C43"));
}

TEST(LockstepOrder, WheelsThatAFrameNeedsGoOutBeforeTheNextFrame) {
  // Wheels at 20 Hz and logged late, frames at 30 Hz: without their readings no mapper answers.
  EXPECT_THAT(order({event("CAMERA", 10'000, 10'000, {10'000}), event("TRUTH", 11'000, 11'000),
                     event("CAMERA", 43'000, 43'000, {43'000}), event("ENCODERS", 60'000, 0),
                     event("ENCODERS", 110'000, 50'000), event("CAMERA", 120'000, 76'000, {76'000}),
                     event("ENCODERS", 160'000, 100'000)}),
              ElementsAre("C10", "T11", "E0", "E50", "C43", "C76", "E100"));
}

TEST(LockstepOrder, ReadingsMayBeOfAnotherKindThanTheWheels) {
  EXPECT_THAT(order({event("CAMERA", 10'000, 10'000, {10'000}), event("CAMERA", 43'000, 43'000, {43'000}),
                     event("TWIST", 60'000, 50'000)},
                    "TWIST"),
              ElementsAre("C10", "T50", "C43"));
}

TEST(LockstepOrder, ADepthImageTakenLaterNeedsLaterWheels) {
  EXPECT_THAT(order({event("CAMERA", 10'000, 10'000, {10'000, 30'000}), event("ENCODERS", 20'000, 20'000),
                     event("CAMERA", 43'000, 43'000, {43'000}), event("ENCODERS", 44'000, 44'000)}),
              ElementsAre("C10", "E20", "E44", "C43"));
}

TEST(LockstepOrder, WheelsFarAwayOrOfAnotherSessionAreNotFetched) {
  EXPECT_THAT(order({event("CAMERA", 10'000, 10'000, {10'000}), event("CAMERA", 43'000, 43'000, {43'000}),
                     event("ENCODERS", 900'000, 900'000)}),
              ElementsAre("C10", "C43", "E900"));
  PlayEvent next = event("ENCODERS", 50'000, 50'000);
  next.begins_session = true;
  EXPECT_THAT(
      order({event("CAMERA", 10'000, 10'000, {10'000}), event("CAMERA", 43'000, 43'000, {43'000}), next}),
      ElementsAre("C10", "C43", "E50"));
}

TEST(LogClock, KeepsIntervalsAtEachSpeed) {
  for (const double speed : {0.5, 1.0, 4.0}) {
    LogClock clock(speed);
    EXPECT_EQ(clock.due(1'000'000, start), start);
    const milliseconds half(static_cast<int>(500 / speed));
    EXPECT_EQ(clock.due(1'500'000, start), start + half);
    EXPECT_EQ(clock.due(1'400'000, start + half), start + 8 * half / 10);  // disorder: at once, no new start
    EXPECT_EQ(clock.due(2'000'000, start + half), start + 2 * half);
    EXPECT_EQ(clock.due(-50'000'000, start + seconds(9)), start + seconds(9));  // another session
    EXPECT_EQ(clock.due(-49'500'000, start + seconds(9)), start + seconds(9) + half);
    EXPECT_NEAR(clock.played(), 1.5, 1e-9);
  }
  LogClock fast(0);
  for (const Utime time : {0, 1'000'000, 1'000'000'000})
    EXPECT_EQ(fast.due(time, start + seconds(time / 1'000'000 % 7)), start + seconds(time / 1'000'000 % 7));
  EXPECT_NEAR(fast.played(), 1000, 1e-9);
}

TEST(LogClock, TimesOfADamagedLogDoNotOverflow) {
  LogClock clock(0.001);
  clock.due(INT64_MIN, start);
  EXPECT_GT(clock.due(INT64_MAX, start), start + std::chrono::hours(24));
  EXPECT_EQ(clock.due(INT64_MIN, start), start);
}

TEST(SocketPace, LetsABurstPassAndThenHoldsTheRate) {
  SocketPace pace;
  Time now = start;
  int at_once = 0;
  for (int i = 0; i < 10'000; ++i) {
    const Time due = pace.due(100, now);
    EXPECT_GE(due, now);
    at_once += due == start ? 1 : 0;
    now = due;
  }
  EXPECT_GT(at_once, 10);
  EXPECT_LT(at_once, 60);  // far below what a socket of 212992 bytes takes
  const double rate = 10'000 / std::chrono::duration<double>(now - start).count();
  EXPECT_GT(rate, 10e3);
  EXPECT_LT(rate, 40e3);
  EXPECT_EQ(pace.due(100, now + seconds(1)), now + seconds(1));  // it recovers
}

}  // namespace
}  // namespace lcmslam
