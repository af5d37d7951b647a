#include <lcmslam/runtime/clock_comparison.hpp>

#include <gmock/gmock.h>

namespace lcmslam {
namespace {

/// Two hosts; `ahead`: us that the second one's clock is ahead.
struct Hosts {
  ClockComparison a{"robot", 1}, b{"base", 2};
  Utime ahead = 0, now = 1'000'000'000;

  void exchange(Utime there, Utime back) {
    const command_t from_a = a.tell(now);
    now += there;
    b.hear(from_a, now + ahead);
    now += 300'000;
    const command_t from_b = b.tell(now + ahead);
    now += back;
    a.hear(from_b, now);
    now += 700'000;
  }
  std::map<std::string, ClockComparison::Offset> seen_by_a() const { return a.offsets(now); }
};

TEST(ClockComparison, FindsTheOffsetOfEqualWaysExactly) {
  Hosts hosts;
  hosts.ahead = 123'456;
  hosts.exchange(2'000, 2'000);
  ASSERT_EQ(hosts.seen_by_a().count("base"), 1U);
  EXPECT_NEAR(hosts.seen_by_a().at("base").offset, 0.123456, 1e-9);
  EXPECT_NEAR(hosts.seen_by_a().at("base").error, 0.002, 1e-9);
}

TEST(ClockComparison, BelievesTheFastestExchangeAndKnowsItsError) {
  Hosts hosts;
  hosts.ahead = -50'000;
  for (const Utime slow : {90'000, 40'000, 3'000, 70'000, 25'000}) {
    hosts.exchange(1'000, slow);
    const auto offset = hosts.seen_by_a().at("base");
    EXPECT_NEAR(offset.offset, -0.05, offset.error + 1e-9);
  }
  EXPECT_NEAR(hosts.seen_by_a().at("base").error, 0.002, 1e-9);
}

TEST(ClockComparison, FollowsAClockThatIsSet) {
  Hosts hosts;
  for (int i = 0; i < 10; ++i) hosts.exchange(1'000, 1'000);
  hosts.ahead = 7'000'000;
  for (int i = 0; i < 9; ++i) hosts.exchange(1'000, 1'000);
  EXPECT_NEAR(hosts.seen_by_a().at("base").offset, 7, 1e-6);
}

TEST(ClockComparison, ForgetsWhoIsSilentAndLeavesGarbageOut) {
  Hosts hosts;
  hosts.exchange(1'000, 1'000);
  command_t garbage = hosts.b.tell(hosts.now);
  garbage.values = {"x y"};
  garbage.sender = 9;
  hosts.a.hear(garbage, hosts.now);
  garbage.values = {std::to_string(INT64_MIN) + " " + std::to_string(INT64_MAX)};
  hosts.a.hear(garbage, hosts.now);
  garbage.name = "stop";
  hosts.a.hear(garbage, hosts.now);
  EXPECT_EQ(hosts.seen_by_a().size(), 1U);
  for (std::int64_t sender = 100; sender < 1000; ++sender) {
    command_t other;
    other.name = "clock";
    other.utime = 5;
    other.sender = sender;
    other.target = std::to_string(sender);
    other.n = 0;
    hosts.a.hear(other, hosts.now);
  }
  EXPECT_LE(hosts.a.tell(hosts.now).n, 64) << "bounded";
  hosts.now += 11'000'000;
  EXPECT_TRUE(hosts.seen_by_a().empty());
}

}  // namespace
}  // namespace lcmslam
