// Several robots' graphs on one bus.

#include <gmock/gmock.h>

#include <lcmslam/encoders_t.hpp>
#include <lcmslam/runtime/bus_robot.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>
#include "tests/support/own_bus.hpp"

namespace lcmslam {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// LCMSLAM_ROBOT for as long as it lives; empty: nobody in particular.
class Speaking {
 public:
  explicit Speaking(const char* name) { setenv("LCMSLAM_ROBOT", name, 1); }
  ~Speaking() { unsetenv("LCMSLAM_ROBOT"); }
  Speaking(const Speaking&) = delete;
  Speaking& operator=(const Speaking&) = delete;
};

std::unique_ptr<BusReader> listen(LcmBus& bus, const char* robot, const ChannelSet& channels) {
  const Speaking as(robot);
  return bus.listen(channels);
}

void send(LcmBus& bus, const char* robot, const std::string& channel, std::size_t largest_whole = 1 << 20,
          std::size_t size = 1) {
  const Speaking as(robot);
  BusSender(bus.lcm(), 7, largest_whole).send(channel, std::vector<std::uint8_t>(size, 'x'), 0);
}

std::vector<std::string> heard(BusReader& reader) {
  std::vector<std::string> channels;
  for (BusMessage message; reader.read(message, milliseconds(0));) channels.push_back(message.channel);
  return channels;
}

TEST(Robots, HearTheirOwnChannelsByTheirPlainNames) {
  LcmBus bus("memq://");
  const auto dora = listen(bus, "dora", ChannelSet({"CAMERA"}));
  const auto ed = listen(bus, "ed", ChannelSet::matching("CAM.*|ODOMETRY"));
  const auto anybody = listen(bus, "", ChannelSet::matching(".*"));
  send(bus, "dora", "CAMERA");
  send(bus, "ed", "CAMERA");
  send(bus, "ed", "ODOMETRY");
  send(bus, "", "CAMERA");
  EXPECT_THAT(heard(*dora), ElementsAre("CAMERA"));
  EXPECT_THAT(heard(*ed), ElementsAre("CAMERA", "ODOMETRY"));
  EXPECT_THAT(heard(*anybody), ElementsAre("dora/CAMERA", "ed/CAMERA", "ed/ODOMETRY", "CAMERA"));
}

TEST(Robots, AlternativesOfAPatternAllStandBelowTheName) {
  const ChannelSet set = ChannelSet::matching("A|B").below("r.1/");
  EXPECT_TRUE(set.holds("r.1/A"));
  EXPECT_TRUE(set.holds("r.1/B"));
  EXPECT_FALSE(set.holds("B"));
  EXPECT_FALSE(set.holds("rx1/A"));
}

TEST(Robots, MessagesInPiecesComeTogetherAndLogsCanTellWhose) {
  const std::string url = own_bus("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152");
  LcmBus bus(url);
  if (!bus.usable()) GTEST_SKIP() << "no multicast route here";
  const auto anybody = listen(bus, "", ChannelSet::matching(".*"));
  const Speaking as("dora");
  Inputs inputs;
  Utime seen = 0;
  inputs.subscribe<encoders_t>("ENCODERS", 10, [&](const encoders_t& m) { seen = m.utime; });
  Receiver receiver(bus, inputs);
  encoders_t message;
  message.utime = 5;
  message.n_wheels = 0;
  LcmPublisher publisher(bus.lcm(), 3, 0);
  message.n_wheels = 4000;  // more than a datagram
  message.wheels.resize(4000);
  publisher.publish("ENCODERS", message);
  ASSERT_EQ(publisher.split(), 1);
  Arrival arrival;
  ASSERT_TRUE(receiver.take(arrival, seconds(10)));
  arrival.deliver();
  EXPECT_EQ(seen, 5);
  BusMessage piece;
  ASSERT_TRUE(anybody->read(piece, seconds(10)));
  EXPECT_EQ(piece.channel, "dora/ENCODERS_PART");
  EXPECT_EQ(decode_message<part_t>(piece.bytes.data(), piece.bytes.size()).channel, "dora/ENCODERS");
}

TEST(Robots, NamesAreChecked) {
  for (const char* good : {"dora", "R2-D2", "base_1", "7"}) EXPECT_NO_THROW(check_robot_name(good)) << good;
  for (const char* wrong : {"", "a/b", "a b", ".*", "a.b", "abcdefghijklmnopqrstuvwxyzabcdefg"})
    EXPECT_THROW(check_robot_name(wrong), std::invalid_argument) << wrong;
  const Speaking as("a/b");
  try {
    LcmBus bus("memq://");
    FAIL() << "it was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("'a/b' must be 1 to 32 letters"));
  }
}

TEST(Robots, AChannelWithoutAName) {
  EXPECT_EQ(without_robot("dora/CAMERA"), "CAMERA");
  EXPECT_EQ(without_robot("CAMERA"), "CAMERA");
}

}  // namespace
}  // namespace lcmslam
