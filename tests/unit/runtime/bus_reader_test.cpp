// Which channels, whose packets: what a reader is told.

#include <gmock/gmock.h>

#include <lcmslam/runtime/buffered_reader.hpp>
#include <lcmslam/runtime/bus.hpp>
#include <lcmslam/runtime/udpm/multicast_address.hpp>
#include <lcmslam/runtime/udpm/source_filter.hpp>

namespace lcmslam {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;
using udpm::parse_networks;
using udpm::SourceFilter;

constexpr std::uint32_t ip(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  return (a << 24) | (b << 16) | (c << 8) | d;
}

TEST(ChannelSet, HoldsNamesOrWholeMatches) {
  const ChannelSet names({"A.B", "C"});
  EXPECT_TRUE(names.holds("A.B"));
  EXPECT_FALSE(names.holds("AxB"));
  const ChannelSet matching = ChannelSet::matching("A|B.*");
  for (const char* channel : {"A", "B", "B1"}) EXPECT_TRUE(matching.holds(channel)) << channel;
  for (const char* channel : {"AB", "xB", ""}) EXPECT_FALSE(matching.holds(channel)) << channel;
  EXPECT_THROW(ChannelSet::matching("A("), std::invalid_argument);
}

// The same through LCM's own subscriptions.
TEST(ChannelSet, MeansTheSameToLcm) {
  const auto heard = [](const ChannelSet& channels) {
    LcmBus bus("memq://");
    const auto reader = bus.listen(channels);
    for (const char* channel : {"A.B", "AxB", "C", "A", "AB", "B1"}) bus.lcm().publish(channel, "x", 1);
    std::vector<std::string> names;
    BusMessage message;
    while (reader->read(message, milliseconds(0))) names.push_back(message.channel);
    return names;
  };
  EXPECT_THAT(heard(ChannelSet({"A.B", "C"})), ::testing::ElementsAre("A.B", "C"));
  EXPECT_THAT(heard(ChannelSet::matching("A|B.*")), ::testing::ElementsAre("A", "B1"));
}

TEST(Networks, AreReadOrRefusedWithWhatWouldBeRight) {
  const auto networks = parse_networks(" 10.0.0.5,10.0.1.0/24  192.168.1.77/16, 0.0.0.0/0 ");
  ASSERT_EQ(networks.size(), 4U);
  EXPECT_TRUE(networks[0].holds(ip(10, 0, 0, 5)));
  EXPECT_FALSE(networks[0].holds(ip(10, 0, 0, 4)));
  EXPECT_TRUE(networks[1].holds(ip(10, 0, 1, 255)));
  EXPECT_FALSE(networks[1].holds(ip(10, 0, 2, 0)));
  EXPECT_TRUE(networks[2].holds(ip(192, 168, 99, 1)));
  EXPECT_FALSE(networks[2].holds(ip(192, 169, 1, 77)));
  EXPECT_TRUE(networks[3].holds(ip(8, 8, 8, 8)));
  EXPECT_TRUE(parse_networks(" , ").empty());
  for (const char* wrong :
       {"robot", "10.0.0", "10.0.0.5/33", "10.0.0.5/-1", "10.0.0.5/", "10.0.0.5/8x", "/8"})
    try {
      parse_networks(std::string("10.0.0.1, ") + wrong);
      ADD_FAILURE() << wrong;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr("'" + std::string(wrong) + "'"));
      EXPECT_THAT(error.what(), HasSubstr("LCMSLAM_BUS_ALLOW"));
    }
}

TEST(Networks, AWrongListIsNoSilentlyOpenBus) {
  setenv("LCMSLAM_BUS_ALLOW", "robot", 1);
  EXPECT_THROW(LcmBus("udpm://239.255.76.67:7667?ttl=1"), std::invalid_argument);
  unsetenv("LCMSLAM_BUS_ALLOW");
}

TEST(LcmBus, MulticastIsNeverReadByLcmItself) {
  EXPECT_THROW(LcmBus("mpudpm://239.255.76.67:7667?ttl=0"), std::invalid_argument);
}

TEST(SourceFilter, TakesThisMachineAlwaysOthersAsConfigured) {
  const std::uint32_t own = ip(10, 0, 0, 1), friendly = ip(10, 0, 0, 5), other = ip(10, 0, 0, 6);
  const auto takes = [&](int ttl, const char* allowed, std::uint32_t address) {
    return SourceFilter(ttl, parse_networks(allowed), [&] { return std::vector<std::uint32_t>{own}; })
        .takes(address, SourceFilter::Time{});
  };
  for (const int ttl : {0, 1})
    for (const char* allowed : {"", "10.0.0.5"}) EXPECT_TRUE(takes(ttl, allowed, own));
  EXPECT_FALSE(takes(0, "", other));
  EXPECT_TRUE(takes(1, "", other));
  EXPECT_FALSE(takes(1, "10.0.0.5", other));
  EXPECT_TRUE(takes(1, "10.0.0.5", friendly));
  EXPECT_TRUE(takes(0, "10.0.0.5", friendly));
}

TEST(SourceFilter, LooksAtTheInterfacesAgainButNotForEveryStranger) {
  int looks = 0;
  std::vector<std::uint32_t> own = {1};
  SourceFilter filter(0, {}, [&] {
    ++looks;
    return own;
  });
  SourceFilter::Time now = SourceFilter::Time{} + seconds(1000);
  EXPECT_TRUE(filter.takes(1, now));
  EXPECT_EQ(looks, 1);
  own = {1, 2};
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(filter.takes(2, now + milliseconds(9 * i)));
  EXPECT_EQ(looks, 1);
  EXPECT_TRUE(filter.takes(2, now + milliseconds(1000)));
  EXPECT_EQ(looks, 2);
  EXPECT_TRUE(filter.takes(1, now + milliseconds(3000)));  // known: nobody looks
  EXPECT_EQ(looks, 2);
}

TEST(SourceFilter, KnowsThisMachine) {
  EXPECT_THAT(udpm::addresses_of_this_machine(), ::testing::IsSupersetOf({ip(127, 0, 0, 1), ip(0, 0, 0, 0)}));
}

TEST(MulticastAddress, HoldsWhatTheUrlAsksFor) {
  const MulticastAddress address = multicast_address("udpm://239.1.2.3:1234?recv_buf_size=9000&ttl=2");
  EXPECT_EQ(address.group, "239.1.2.3");
  EXPECT_EQ(address.port, 1234);
  EXPECT_EQ(address.ttl, 2);
  EXPECT_EQ(address.receive_buffer, 9000);
  EXPECT_EQ(multicast_address("udpm://239.1.2.3:1234").receive_buffer, 0);
  EXPECT_EQ(multicast_address("udpm://239.1.2.3:1234?xttl=3").ttl, 0);
  EXPECT_EQ(multicast_address("udpm://239.1.2.3:1234?ttl=3&").ttl, 3);
  EXPECT_THROW(multicast_address("udpm://239.1.2.3:1234?ttl=far"), std::invalid_argument);
  EXPECT_THROW(multicast_address("udpm://224.0.0.255:1234"), std::invalid_argument);
  EXPECT_EQ(multicast_address("udpm://224.0.1.0:1234").group, "224.0.1.0");
}

/// Hands out messages, then says that it is broken, once.
class Tape : public BusReader {
 public:
  explicit Tape(int messages) : left_(messages) {}
  bool read(BusMessage& message, milliseconds) override {
    if (left_ == 0) {
      --left_;
      throw std::runtime_error("the wire was cut");
    }
    if (left_ < 0) return false;
    message = {std::to_string(left_--), {}};
    return true;
  }

 private:
  int left_;
};

TEST(BufferedReader, KeepsTheOrderAndPassesOnWhatWentWrong) {
  BufferedReader reader(std::make_unique<Tape>(3));
  BusMessage message;
  for (const char* channel : {"3", "2", "1"}) {
    ASSERT_TRUE(reader.read(message, seconds(20)));
    EXPECT_EQ(message.channel, channel);
  }
  EXPECT_THROW(reader.read(message, seconds(20)), std::runtime_error);
  EXPECT_FALSE(reader.read(message, milliseconds(1)));
}

TEST(BufferedReader, ThrowsAwayTheNewestWhenNobodyReads) {
  BufferedReader reader(std::make_unique<Tape>(20'100));
  BusMessage message;
  const auto deadline = std::chrono::steady_clock::now() + seconds(20);
  while (reader.dropped() < 100 && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  EXPECT_EQ(reader.dropped(), 100);
  ASSERT_TRUE(reader.read(message, seconds(20)));
  EXPECT_EQ(message.channel, "20100");
}

}  // namespace
}  // namespace lcmslam
