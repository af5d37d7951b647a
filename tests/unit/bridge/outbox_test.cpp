#include <lcmslam/bridge/outbox.hpp>

#include <gmock/gmock.h>

namespace lcmslam::bridge {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class OutboxTest : public ::testing::Test {
 protected:
  void connect(std::uint64_t mark = 0) {
    outbox_.connected();
    outbox_.broker_keeps(mark);
  }
  void keep(const std::string& group, std::size_t size = 100) {
    outbox_.keep("MAP", group, {{"MAP/" + group, Bytes(size, 'm')}});
  }
  /// All that goes now, each acknowledged at once.
  std::vector<std::string> send_all() {
    std::vector<std::string> names;
    while (const auto out = outbox_.next(now_)) {
      names.push_back(out->name + (out->bytes->empty() ? " cleared" : ""));
      outbox_.acknowledged(out->ticket, now_);
    }
    return names;
  }
  static Bytes text(const std::string& text) { return {text.begin(), text.end()}; }

  Time now_ = Time(seconds(1000));
  Outbox outbox_{parse_rules({"POSE@5", "ORDERS", "MAP", "PICTURE@1"}), {}};
};

TEST_F(OutboxTest, OfAMeasurementTheNewestOfEachSenderGoesAtItsRate) {
  connect();
  for (const char* pose : {"1", "2", "3"}) outbox_.put("POSE", 7, text(pose), now_);
  outbox_.put("POSE", 8, text("other"), now_);
  auto out = outbox_.next(now_);
  ASSERT_TRUE(out);
  EXPECT_EQ(*out->bytes, text("3"));
  EXPECT_FALSE(out->kept);
  EXPECT_EQ(outbox_.counts().replaced, 2);
  out = outbox_.next(now_);
  ASSERT_TRUE(out);
  EXPECT_EQ(*out->bytes, text("other"));
  int sent = 0;
  for (int i = 0; i < 1000; ++i) {  // 10 s at 100 Hz
    now_ += milliseconds(10);
    outbox_.put("POSE", 7, text("x"), now_);
    sent += static_cast<int>(send_all().size());
  }
  EXPECT_NEAR(sent, 50, 1);
}

TEST_F(OutboxTest, OfAChannelWithoutARateAllGoInTheirOrder) {
  connect();
  for (const char* order : {"a", "b", "c"}) outbox_.put("ORDERS", 1, text(order), now_);
  std::string all;
  while (const auto out = outbox_.next(now_)) {
    all += std::string(out->bytes->begin(), out->bytes->end());
    outbox_.acknowledged(out->ticket, now_);
  }
  EXPECT_EQ(all, "abc");
  for (int i = 0; i < 1000; ++i) outbox_.put("ORDERS", 1, text("x"), now_);
  EXPECT_EQ(send_all().size(), 64U) << "bounded";
}

TEST_F(OutboxTest, WhatIsSmallGoesFirstAndOfTheMapTheNewest) {
  connect();
  keep("1");
  keep("2");
  outbox_.put("PICTURE", 1, text("p"), now_);
  outbox_.put("POSE", 1, text("p"), now_);
  EXPECT_THAT(send_all(), ElementsAre("POSE", "PICTURE", "MAP/2", "MAP/1"));
}

TEST_F(OutboxTest, WhatIsLargeSharesTheLink) {
  Outbox outbox(parse_rules({"LANDMARKS@1", "MAP"}), {});
  outbox.connected();
  outbox.broker_keeps(0);
  for (int i = 0; i < 100; ++i) {
    const std::string name = "MAP/" + std::to_string(i);
    outbox.keep("MAP", std::to_string(i), {{name, Bytes(8'000, 'm')}});
  }
  std::size_t landmarks = 0, map = 0;
  for (int i = 0; i < 100; ++i) {  // whose changes never end
    if (outbox.wants("LANDMARKS", now_)) outbox.put("LANDMARKS", 1, Bytes(16'000, 'l'), now_);
    const auto out = outbox.next(now_);
    ASSERT_TRUE(out);
    (out->name == "LANDMARKS" ? landmarks : map) += out->bytes->size();
    outbox.acknowledged(out->ticket, now_);
    now_ += seconds(1);
  }
  EXPECT_NEAR(static_cast<double>(landmarks), static_cast<double>(map), 16'000);
}

TEST_F(OutboxTest, OfTheMapOnlySoMuchIsUnderWayAsTheLinkCarries) {
  connect();
  for (int i = 0; i < 20; ++i) keep(std::to_string(i), 8'000);
  int under_way = 0;
  while (outbox_.next(now_)) ++under_way;
  EXPECT_EQ(under_way, 3) << "32 kB at the beginning";
}

TEST_F(OutboxTest, AChannelThatWaitedForNothingHasNoClaimOnAllOfTheLink) {
  Outbox outbox(parse_rules({"A", "B"}), {});
  outbox.connected();
  outbox.broker_keeps(0);
  const auto send = [&](int times) {
    std::string names;
    for (int i = 0; i < times; ++i) {
      const auto out = outbox.next(now_);
      if (!out) break;
      names += out->name;
      outbox.acknowledged(out->ticket, now_);
    }
    return names;
  };
  for (int i = 0; i < 30; ++i) outbox.put("A", 1, Bytes(4'000, 'a'), now_);
  EXPECT_EQ(send(20), std::string(20, 'A'));
  for (int i = 0; i < 10; ++i) outbox.put("B", 1, Bytes(4'000, 'b'), now_);
  EXPECT_THAT(send(6), ::testing::AnyOf("BABABA", "ABABAB"));
}

TEST_F(OutboxTest, PiecesOfAMeasurementGoAllAndThenItRests) {
  connect();
  outbox_.put("PICTURE", 1, {{"PICTURE_PART/0", text("a")}, {"PICTURE_PART/1", text("b")}}, now_);
  EXPECT_FALSE(outbox_.wants("PICTURE", now_));
  EXPECT_THAT(send_all(), ElementsAre("PICTURE_PART/0", "PICTURE_PART/1"));
  EXPECT_FALSE(outbox_.wants("PICTURE", now_)) << "one a second";
  now_ += seconds(1);
  EXPECT_TRUE(outbox_.wants("PICTURE", now_));
}

TEST_F(OutboxTest, ASmallMeasurementWaitsForNothingThatStandsBeforeIt) {
  Outbox outbox(parse_rules({"STATUS@1", "POSE@5", "ORDERS", "MAP"}), {});
  outbox.connected();
  outbox.broker_keeps(0);
  outbox.keep("MAP", "1", {{"MAP/1", Bytes(31'000, 'm')}});
  const auto map = outbox.next(now_);  // the window is full with it
  ASSERT_TRUE(map);
  outbox.put("STATUS", 1, Bytes(2000, 's'), now_);
  outbox.put("POSE", 1, Bytes(500, 'p'), now_);
  outbox.put("ORDERS", 1, Bytes(500, 'o'), now_);
  outbox.keep("MAP", "2", {{"MAP/2", Bytes(10, 'm')}});
  const auto pose = outbox.next(now_);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->name, "POSE");
  EXPECT_FALSE(outbox.next(now_)) << "neither an order without a rate nor a map passes a STATUS that waits";
  outbox.acknowledged(map->ticket, now_);
  std::vector<std::string> names;
  while (const auto out = outbox.next(now_)) names.push_back(out->name);
  EXPECT_THAT(names, ElementsAre("STATUS", "ORDERS", "MAP/2"));
}

TEST_F(OutboxTest, SmallMeasurementsGoBesideTheMapOnTheirOwnWayTwentyAtATime) {
  connect();
  for (int i = 0; i < 30; ++i) {
    keep(std::to_string(i), 10);
    outbox_.put("POSE", i, text("p"), now_);
  }
  std::vector<std::uint64_t> poses;
  int map = 0;
  while (const auto out = outbox_.next(now_)) {
    EXPECT_EQ(out->beside, out->name == "POSE");
    if (out->beside)
      poses.push_back(out->ticket);
    else
      ++map;
  }
  EXPECT_EQ(poses.size(), 20U) << "brokers take 20 at a time";
  EXPECT_EQ(map, 20) << "on each connection";
  outbox_.acknowledged(poses.front(), now_);
  const auto pose = outbox_.next(now_);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->name, "POSE");
  EXPECT_FALSE(outbox_.next(now_));
  outbox_.disconnected();
  connect();
  outbox_.put("POSE", 1, text("p"), now_ + seconds(1));
  now_ += seconds(1);
  const auto again = outbox_.next(now_);
  ASSERT_TRUE(again) << "what was under way is no more";
  EXPECT_TRUE(again->beside);
}

TEST_F(OutboxTest, SmallMeasurementsTakeNothingOfTheWindow) {
  connect();
  for (int i = 0; i < 20; ++i) outbox_.put("POSE", i, Bytes(1'400, 'p'), now_);
  while (outbox_.next(now_)) {
  }
  for (int i = 0; i < 20; ++i) keep(std::to_string(i), 8'000);
  int map = 0;
  while (outbox_.next(now_)) ++map;
  EXPECT_EQ(map, 3) << "32 kB at the beginning";
}

TEST_F(OutboxTest, ASendersMeasurementsDoNotPassEachOtherOnTwoConnections) {
  connect();
  const auto way = [&](std::size_t bytes) {
    now_ += seconds(1);
    outbox_.put("POSE", 1, Bytes(bytes, 'p'), now_);
    const auto out = outbox_.next(now_);
    return out ? (out->beside ? "small" : "large") : "none";
  };
  EXPECT_STREQ(way(1'000), "small");
  EXPECT_STREQ(way(2'000), "large");
  EXPECT_STREQ(way(1'000), "large") << "the large one may still be under way";
}

TEST_F(OutboxTest, NothingGoesWithoutAConnectionAndMeasurementsOfThatTimeNeverGo) {
  outbox_.put("POSE", 1, text("old"), now_);
  keep("1");
  EXPECT_FALSE(outbox_.next(now_));
  outbox_.disconnected();
  outbox_.connected();
  EXPECT_FALSE(outbox_.next(now_)) << "what the broker keeps is not known";
  outbox_.broker_keeps(0);
  EXPECT_THAT(send_all(), ElementsAre("MAP/1"));
}

TEST_F(OutboxTest, AnOrderThatWasGivenBetweenTwoConnectionsIsNotObeyedLater) {
  connect();
  outbox_.disconnected();
  outbox_.put("ORDERS", 1, text("go there"), now_);
  outbox_.put("POSE", 1, text("old"), now_);
  now_ += seconds(40);  // an attempt that failed in vain, and the longest pause
  connect();
  EXPECT_THAT(send_all(), IsEmpty());
  outbox_.put("ORDERS", 1, text("stop"), now_);
  EXPECT_THAT(send_all(), ElementsAre("ORDERS"));
}

TEST_F(OutboxTest, WhatWasUnderWayWhenTheConnectionEndedGoesAgain) {
  connect();
  keep("1");
  keep("2");
  const auto lost = outbox_.next(now_);
  ASSERT_TRUE(lost);
  outbox_.disconnected();
  outbox_.acknowledged(lost->ticket, now_);  // too late: nobody knows whether it is true
  connect();
  EXPECT_THAT(send_all(), ElementsAre("MAP/2", "MAP/1"));
}

TEST_F(OutboxTest, WhatABrokerForgotGoesAgainAndNothingElse) {
  connect();
  for (const char* group : {"1", "2", "3"}) keep(group);
  send_all();
  EXPECT_EQ(outbox_.mark(), 3U);
  outbox_.disconnected();
  connect(3);  // it has all
  EXPECT_THAT(send_all(), IsEmpty());
  outbox_.disconnected();
  connect(1);  // it came back with what was on its disk
  EXPECT_THAT(send_all(), ElementsAre("MAP/3", "MAP/2"));
  outbox_.disconnected();
  connect(0);  // it came back with nothing
  EXPECT_THAT(send_all(), ElementsAre("MAP/3", "MAP/2", "MAP/1"));
}

TEST_F(OutboxTest, TheBrokerIsToldAnewBeforeItForgetsTheMapOfARobotThatIsThere) {
  connect();
  keep("1");
  keep("2");
  ASSERT_THAT(send_all(), ElementsAre("MAP/2", "MAP/1"));
  now_ += seconds(300'000);
  keep("2");
  EXPECT_THAT(send_all(), ElementsAre("MAP/2"));
  now_ += seconds(3'000);  // in all more than half of the week for which the broker keeps it
  EXPECT_THAT(send_all(), ElementsAre("MAP/1"));
  EXPECT_THAT(send_all(), IsEmpty());
  EXPECT_EQ(outbox_.mark(), 4U);
}

TEST_F(OutboxTest, TheMarkIsBelowTheOldestThatTheBrokerHasNot) {
  connect();
  for (const char* group : {"1", "2", "3"}) keep(group);
  const auto third = outbox_.next(now_);
  outbox_.acknowledged(third->ticket, now_);
  EXPECT_EQ(outbox_.mark(), 0U);
  const auto second = outbox_.next(now_);
  const auto first = outbox_.next(now_);
  outbox_.acknowledged(first->ticket, now_);
  EXPECT_EQ(outbox_.mark(), 1U);
  EXPECT_FALSE(outbox_.idle());
  outbox_.acknowledged(second->ticket, now_);
  EXPECT_EQ(outbox_.mark(), 3U);
  EXPECT_TRUE(outbox_.idle());
}

TEST_F(OutboxTest, AnotherKeptMessageOfTheSameNameReplacesIt) {
  connect();
  keep("1", 10);
  const auto old = outbox_.next(now_);
  keep("1", 20);
  outbox_.acknowledged(old->ticket, now_);
  EXPECT_EQ(outbox_.mark(), 1U) << "its successor is not there yet";
  const auto out = outbox_.next(now_);
  ASSERT_TRUE(out);
  EXPECT_EQ(out->bytes->size(), 20U);
}

TEST_F(OutboxTest, WhatWasBegunIsFinishedBeforeWhatIsNewer) {
  connect();
  outbox_.keep("MAP", "old", {{"MAP/old/0", text("a")}, {"MAP/old/1", text("b")}});
  const auto piece = outbox_.next(now_);
  EXPECT_EQ(piece->name, "MAP/old/1");
  keep("new");
  EXPECT_THAT(send_all(), ElementsAre("MAP/old/0", "MAP/new"));
}

TEST_F(OutboxTest, PiecesThatAMessageHasNoMoreAreCleared) {
  connect();
  outbox_.keep("MAP", "g", {{"MAP_PART/g/0", text("a")}, {"MAP_PART/g/1", text("b")}});
  send_all();
  outbox_.keep("MAP", "g", {{"MAP/g", text("c")}});
  EXPECT_THAT(send_all(), ElementsAre("MAP_PART/g/1 cleared", "MAP_PART/g/0 cleared", "MAP/g"));
  outbox_.keep("MAP", "g", {{"MAP/g", text("d")}});
  EXPECT_THAT(send_all(), ElementsAre("MAP/g")) << "they are cleared";
}

TEST_F(OutboxTest, WhatIsForgottenIsClearedOnce) {
  connect();
  for (const char* group : {"f/1/0", "f/1/1", "f/10/0"}) keep(group);
  send_all();
  outbox_.forget("MAP", "f/1/");
  EXPECT_THAT(send_all(), ElementsAre("MAP/f/1/1 cleared", "MAP/f/1/0 cleared"));
  outbox_.forget("MAP", "f/1/");
  EXPECT_THAT(send_all(), IsEmpty());
}

TEST_F(OutboxTest, ChangesAreWantedOneAfterTheOther) {
  EXPECT_FALSE(outbox_.wants("PICTURE", now_));
  connect();
  EXPECT_TRUE(outbox_.wants("PICTURE", now_));
  EXPECT_FALSE(outbox_.wants("OTHER", now_));
  outbox_.put("PICTURE", 1, text("p"), now_);
  EXPECT_FALSE(outbox_.wants("PICTURE", now_)) << "one waits";
  const auto out = outbox_.next(now_);
  EXPECT_FALSE(outbox_.wants("PICTURE", now_ + seconds(2))) << "it is under way";
  outbox_.acknowledged(out->ticket, now_);
  EXPECT_FALSE(outbox_.wants("PICTURE", now_ + milliseconds(900))) << "too soon";
  EXPECT_TRUE(outbox_.wants("PICTURE", now_ + milliseconds(1100)));
}

TEST(OutboxMemory, WhatTheBrokerHasGoesFirstAndItsLossIsTold) {
  OutboxLimits limits;
  limits.memory = 3000;
  Outbox outbox(parse_rules({"MAP"}), limits);
  const Time now(seconds(1000));
  const auto keep = [&](const std::string& group) {
    outbox.keep("MAP", group, {{"MAP/" + group, Bytes(900, 'm')}});
  };
  outbox.connected();
  outbox.broker_keeps(0);
  for (const char* group : {"1", "2", "3"}) keep(group);
  while (const auto out = outbox.next(now)) outbox.acknowledged(out->ticket, now);
  outbox.disconnected();
  keep("4");
  outbox.connected();
  outbox.broker_keeps(3);
  EXPECT_FALSE(outbox.lacks()) << "the broker has what went";
  outbox.disconnected();
  outbox.connected();
  outbox.broker_keeps(0);
  EXPECT_TRUE(outbox.lacks()) << "1 must be told again";
  EXPECT_FALSE(outbox.lacks()) << "once";
  for (const char* group : {"5", "6", "7", "8"}) keep(group);
  EXPECT_LE(outbox.counts().kept_bytes, limits.memory);
  EXPECT_TRUE(outbox.lacks()) << "what never went is gone";
}

TEST(OutboxBandwidth, IsNotExceeded) {
  OutboxLimits limits;
  limits.bandwidth = 20'000;
  Outbox outbox(parse_rules({"MAP"}), limits);
  Time now(seconds(1000));
  outbox.connected();
  outbox.broker_keeps(0);
  for (int i = 0; i < 1000; ++i)
    outbox.keep("MAP", std::to_string(i), {{"MAP/" + std::to_string(i), Bytes(936, 'm')}});
  std::size_t bytes = 0;
  for (int i = 0; i < 1000; ++i, now += milliseconds(10))
    while (const auto out = outbox.next(now)) {
      bytes += out->bytes->size() + 64;
      outbox.acknowledged(out->ticket, now);
    }
  EXPECT_NEAR(static_cast<double>(bytes), 200'000 + 8'000, 2'000);
}

}  // namespace
}  // namespace lcmslam::bridge
