#include "procs/bridge/incoming.hpp"

#include <gmock/gmock.h>

#include <lcmslam/command_t.hpp>
#include <lcmslam/graph_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/messages/any_message.hpp>
#include <lcmslam/messages/decode.hpp>

namespace lcmslam {
namespace {

using Refused = Incoming::Refused;

class IncomingTest : public ::testing::Test {
 protected:
  std::optional<Incoming::Message> take(Incoming& incoming, const std::string& channel,
                                        const std::vector<std::uint8_t>& bytes, bool kept = false) {
    return incoming.take(channel, bytes.data(), bytes.size(), kept, now_);
  }
  static std::vector<std::uint8_t> order(std::size_t length = 4) {
    command_t command{};
    command.utime = 77;
    command.name.assign(length, 's');
    return encode_message(command);
  }
  Incoming::Time now_ = Incoming::Time(std::chrono::seconds(1000));
  Incoming robot_{bridge::parse_rules({"COMMAND"}), bridge::Side::robot};
  Incoming other_{bridge::parse_rules({"COMMAND"}), bridge::Side::operating};
};

TEST_F(IncomingTest, WhatIsAllowedAndSoundPassesAsItIs) {
  const auto message = take(robot_, "COMMAND", order());
  ASSERT_TRUE(message);
  EXPECT_EQ(message->channel, "COMMAND");
  EXPECT_EQ(message->utime, 77);
  EXPECT_EQ(message->bytes, order());
  EXPECT_EQ(robot_.refused(), 0);
}

TEST_F(IncomingTest, OtherChannelsAreRefused) {
  for (const char* channel : {"CAMERA", "COMMANDS", "", "COMMAND_PART_PART", "_PART"})
    EXPECT_FALSE(take(robot_, channel, order())) << channel;
  EXPECT_EQ(robot_.count(Refused::not_allowed), 5);
}

TEST_F(IncomingTest, AnOrderIsNeverTakenFromTheBrokersMemory) {
  EXPECT_FALSE(take(robot_, "COMMAND", order(), true));
  EXPECT_EQ(robot_.count(Refused::from_memory), 1);
  EXPECT_TRUE(take(other_, "COMMAND", order(), true));
}

TEST_F(IncomingTest, AFloodIsThinned) {
  int taken = 0;
  for (int i = 0; i < 1000; ++i, now_ += std::chrono::milliseconds(1))
    taken += take(robot_, "COMMAND", order()) ? 1 : 0;
  EXPECT_LE(taken, 20);
  EXPECT_GE(taken, 10);
  EXPECT_EQ(robot_.count(Refused::too_often), 1000 - taken - 1);
  now_ += std::chrono::milliseconds(101);
  EXPECT_THAT(robot_.due(now_), ::testing::SizeIs(1)) << "the last";
  EXPECT_THAT(robot_.due(now_ + std::chrono::seconds(1)), ::testing::IsEmpty());
}

TEST_F(IncomingTest, AStopAfterABurstComesAsSoonAsTheRateAllows) {
  for (std::size_t length = 1; length <= 15; ++length) {  // 10 pass
    EXPECT_THAT(robot_.due(now_), ::testing::IsEmpty());
    EXPECT_EQ(take(robot_, "COMMAND", order(length)).has_value(), length <= 10);
  }
  EXPECT_EQ(robot_.count(Refused::too_often), 4);
  now_ += std::chrono::milliseconds(50);
  EXPECT_THAT(robot_.due(now_), ::testing::IsEmpty());
  now_ += std::chrono::milliseconds(51);
  const auto late = robot_.due(now_);
  ASSERT_THAT(late, ::testing::SizeIs(1));
  EXPECT_EQ(late[0].channel, "COMMAND");
  EXPECT_EQ(late[0].bytes, order(15)) << "the last word";
  EXPECT_FALSE(take(robot_, "COMMAND", order(16))) << "what waited counts";
  EXPECT_EQ(robot_.count(Refused::too_often), 4);
}

TEST_F(IncomingTest, WhatWaitsGivesWayToSoundMessagesOnly) {
  for (std::size_t length = 1; length <= 11; ++length) take(robot_, "COMMAND", order(length));
  auto garbage = order(12);
  garbage.pop_back();
  EXPECT_FALSE(take(robot_, "COMMAND", garbage));
  command_t all{};
  all.name = "resend";
  EXPECT_FALSE(take(robot_, "COMMAND", encode_message(all)));
  EXPECT_FALSE(take(robot_, "COMMAND_PART", order(13)));
  now_ += std::chrono::milliseconds(101);
  const auto late = robot_.due(now_);
  ASSERT_THAT(late, ::testing::SizeIs(1));
  EXPECT_EQ(late[0].bytes, order(11));
}

TEST_F(IncomingTest, AnOrderIsNotCarriedOutSecondsLater) {
  Incoming slow(bridge::parse_rules({"COMMAND@0.1"}), bridge::Side::robot);
  Incoming shown(bridge::parse_rules({"STATUS@0.1"}), bridge::Side::operating);
  for (std::size_t length = 1; length <= 3; ++length) {
    take(slow, "COMMAND", order(length));
    take(shown, "STATUS", order(length));
  }
  now_ += std::chrono::milliseconds(10'001);
  EXPECT_THAT(slow.due(now_), ::testing::IsEmpty());
  EXPECT_EQ(slow.count(Refused::too_often), 1);
  EXPECT_THAT(shown.due(now_), ::testing::SizeIs(1)) << "the last state is not for now alone";
}

TEST_F(IncomingTest, GarbageIsCountedAndNamed) {
  auto bytes = order();
  bytes.pop_back();
  EXPECT_FALSE(take(robot_, "COMMAND", bytes));
  EXPECT_FALSE(take(robot_, "COMMAND", {}));
  EXPECT_FALSE(take(robot_, "COMMAND_PART", order()));
  EXPECT_EQ(robot_.count(Refused::malformed), 3);
  EXPECT_THAT(robot_.last_error(), ::testing::HasSubstr("COMMAND"));
  EXPECT_FALSE(take(robot_, "COMMAND", order(200'000)));
  EXPECT_EQ(robot_.count(Refused::too_big), 1);
  EXPECT_FALSE(take(other_, "COMMAND", {}, true)) << "what the broker keeps no more is no message";
  EXPECT_EQ(other_.refused(), 0);
}

// A graph of forty pieces each second is one message a second.
TEST_F(IncomingTest, ARateIsOfWholeMessages) {
  Incoming graphs(bridge::parse_rules({"ICP_GRAPH@1"}), bridge::Side::operating);
  int came = 0;
  for (std::int32_t second = 0; second < 5; ++second, now_ += std::chrono::milliseconds(1010)) {
    came += static_cast<int>(graphs.due(now_).size());
    for (const auto& part : split_message("ICP_GRAPH", order(40'000), 77, second, 1000))
      came += take(graphs, "ICP_GRAPH_PART", encode_message(part)) ? 1 : 0;
  }
  EXPECT_EQ(came, 5);
  EXPECT_EQ(graphs.refused(), 0);
  for (std::int32_t message = 10; message < 20; ++message)
    for (const auto& part : split_message("ICP_GRAPH", order(40'000), 77, message, 1000))
      came += take(graphs, "ICP_GRAPH_PART", encode_message(part)) ? 1 : 0;
  EXPECT_LE(came, 5 + 2) << "a burst";
  EXPECT_THAT(graphs.due(now_ + std::chrono::seconds(1)), ::testing::SizeIs(1)) << "the last word";
}

// The broker keeps what a former run of the robot's bridge told, in whatever order it comes.
TEST_F(IncomingTest, AMapDoesNotGoBackToWhatABrokerKeptOfBefore) {
  Incoming maps(bridge::parse_rules({"ICP_GRAPH", "FASTSLAM_LANDMARKS"}), bridge::Side::operating);
  const auto graph = [&](Utime utime, int change, const std::string& frame = "map") {
    graph_t message{};
    message.utime = utime;
    message.sender = 5;
    message.frame = frame;
    message.change = static_cast<std::int8_t>(change);
    return take(maps, "ICP_GRAPH", encode_message(message), change == 0).has_value();
  };
  const auto landmarks = [&](Utime utime, std::int64_t base) {
    landmarks_t message{};
    message.utime = utime;
    message.sender = 5;
    message.frame = "map";
    message.base_revision = base;
    message.n_tiles = 1;
    return take(maps, "FASTSLAM_LANDMARKS", encode_message(message), base == 0).has_value();
  };
  EXPECT_TRUE(graph(100, 0));
  EXPECT_FALSE(graph(50, 0));
  EXPECT_TRUE(graph(100, 0)) << "no older";
  EXPECT_TRUE(graph(50, 0, "map-2")) << "another map";
  EXPECT_TRUE(graph(150, 1));
  EXPECT_FALSE(graph(100, 0)) << "what came since would be lost";
  EXPECT_TRUE(graph(200, 0));
  EXPECT_TRUE(landmarks(30, 0));
  EXPECT_FALSE(landmarks(20, 0));
  EXPECT_TRUE(landmarks(40, 3));
  EXPECT_FALSE(landmarks(30, 0));
  EXPECT_EQ(maps.refused(), 0);
}

TEST_F(IncomingTest, AnOrderInPiecesIsNoLargerThanAnyOther) {
  for (const auto& part : split_message("COMMAND", order(200'000), 77, 3, 60'000))
    EXPECT_FALSE(take(robot_, "COMMAND_PART", encode_message(part)));
  EXPECT_EQ(robot_.count(Refused::too_big), 4);
  int came = 0;
  for (const auto& part : split_message("COMMAND", order(90'000), 77, 4, 60'000))
    came += take(robot_, "COMMAND_PART", encode_message(part)) ? 1 : 0;
  EXPECT_EQ(came, 1);
}

TEST_F(IncomingTest, PiecesBecomeTheirMessage) {
  const auto bytes = order(5000);
  auto parts = split_message("COMMAND", bytes, 77, 3, 1000);
  std::optional<Incoming::Message> whole;
  for (auto& part : parts) {
    EXPECT_FALSE(whole);
    whole = take(other_, "COMMAND_PART", encode_message(part));
  }
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->bytes, bytes);
  parts[0].channel = "STATUS";
  EXPECT_FALSE(take(other_, "COMMAND_PART", encode_message(parts[0])));
  EXPECT_EQ(other_.count(Refused::malformed), 1);
  parts[0].channel = "COMMAND";
  parts[0].message = 9;
  parts[0].total_size = 100 << 20;
  EXPECT_FALSE(take(other_, "COMMAND_PART", encode_message(parts[0])));
  EXPECT_EQ(other_.count(Refused::too_big), 1);
}

}  // namespace
}  // namespace lcmslam
