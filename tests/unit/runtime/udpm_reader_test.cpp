// The reader of UDP multicast against the real LCM as sender, against datagrams made to kill, and against
// another machine. Each test is alone on its bus.

#include <gmock/gmock.h>

#include <atomic>
#include <lcm/lcm-cpp.hpp>
#include <thread>

#include <lcmslam/runtime/bus.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/udpm/udpm_reader.hpp>
#include "tests/support/neighbour.hpp"
#include "tests/support/own_bus.hpp"

namespace lcmslam {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::Bytes;
using testing::bytes_of;
using ::testing::HasSubstr;
using testing::killing_datagrams;
using testing::Neighbour;
using testing::UdpSender;
using testing::whole_datagram;

constexpr const char* group = "239.255.76.67";

class UdpmReaderTest : public ::testing::Test {
 protected:
  void listen(const std::string& url, const std::string& channels = ".*") {
    address_ = multicast_address(url);
    reader_ = LcmBus(url).listen(ChannelSet::matching(channels));
  }

  /// The next message of that channel, with what came before it in `others_`.
  std::optional<BusMessage> next(const std::string& channel) {
    const auto deadline = std::chrono::steady_clock::now() + seconds(20);
    BusMessage message;
    while (std::chrono::steady_clock::now() < deadline)
      if (reader_->read(message, milliseconds(100))) {
        if (message.channel == channel) return message;
        others_.push_back(message.channel);
      }
    return std::nullopt;
  }
  /// All that was sent before has been read then.
  void read_until_last() {
    UdpSender().send(group, address_.port, whole_datagram("LAST", {}));
    ASSERT_TRUE(next("LAST")) << "the last message did not arrive";
  }

  MulticastAddress address_;
  std::unique_ptr<BusReader> reader_;
  std::vector<std::string> others_;
};

TEST_F(UdpmReaderTest, TakesWhatLcmSendsByteForByte) {
  const std::string url = own_bus(default_lcm_url);
  listen(url);
  lcm::LCM sender(url);
  ASSERT_TRUE(sender.good());
  // Where LCM begins to cut is 65499 bytes with the channel's name.
  for (const std::size_t size : {0U, 1U, 100U, 60'000U, 65'490U, 65'491U, 65'492U, 65'493U, 65'494U, 65'495U,
                                 65'600U, 130'966U, 130'967U, 130'968U, 300'000U}) {
    Bytes bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i * 7 + i / 251);
    ASSERT_EQ(sender.publish("CAMERA", bytes.data(), static_cast<unsigned>(size)), 0);
    const auto message = next("CAMERA");
    ASSERT_TRUE(message) << size;
    EXPECT_EQ(message->bytes, bytes) << size;
  }
  EXPECT_EQ(reader_->refusals().text(), "");
}

/// The card that multicast takes, put in and pulled out.
class Card {
 public:
  static bool put_in() {
    return run("ip link add card0 type veth peer name card1") && run("ip link set card1 up") &&
           run("ip address add 10.76.68.1/24 dev card0") && run("ip link set card0 up") &&
           run("ip route replace 224.0.0.0/4 dev card0");
  }
  static bool pull_out() { return run("ip link delete card0"); }
  ~Card() { run("ip link delete card0; ip route replace 224.0.0.0/4 dev lo"); }

 private:
  static bool run(const std::string& command) {
    return std::system(("(" + command + ") 2> /dev/null").c_str()) == 0;
  }
};

// A WLAN stick loses its plug, a bridge is made anew. More often than a socket may be a member.
TEST_F(UdpmReaderTest, ACardThatComesBackIsHeard) {
  const std::string url = own_bus(default_lcm_url);
  if (url != default_lcm_url) GTEST_SKIP() << "no network cards of its own on this machine";
  const Card card;  // of the private network: that of the machine stays as it is
  if (!Card::put_in()) GTEST_SKIP() << "no network cards of its own on this machine";
  listen(url);
  const auto hears_within = [&](seconds patience) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    BusMessage message;
    while (std::chrono::steady_clock::now() < deadline) {
      UdpSender().send(group, address_.port, whole_datagram("POSE", {1}));
      if (reader_->read(message, milliseconds(100))) return true;
    }
    return false;
  };
  ASSERT_TRUE(hears_within(seconds(5)));
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(Card::pull_out());
    BusMessage message;
    reader_->read(message, milliseconds(1100));  // while there is no route
    ASSERT_TRUE(Card::put_in());
    EXPECT_TRUE(hears_within(seconds(5))) << i;
  }
}

TEST_F(UdpmReaderTest, OtherChannelsAreLeftOut) {
  const std::string url = own_bus(default_lcm_url);
  listen(url, "A|B.*|LAST");
  lcm::LCM sender(url);
  const Bytes big(200'000);
  for (const char* channel : {"A", "AB", "B1", "C"}) {
    sender.publish(channel, "x", 1);
    sender.publish(channel, big.data(), static_cast<unsigned>(big.size()));
    read_until_last();
  }
  EXPECT_THAT(others_, ::testing::ElementsAre("A", "A", "B1", "B1"));
  EXPECT_EQ(reader_->refusals().text(), "");
}

TEST_F(UdpmReaderTest, KillingDatagramsAreRefusedAndCounted) {
  listen(own_bus(default_lcm_url));
  const UdpSender stranger;
  for (const Bytes& datagram : killing_datagrams("CAMERA")) stranger.send(group, address_.port, datagram);
  stranger.send(group, address_.port, bytes_of("LC02\1\1\1\1CHANNEL WITHOUT END"));
  // A fragment that is said to be its message's only one, but holds a part of it.
  stranger.send(group, address_.port,
                testing::fragment_datagram({1, 9, 0, 0, 1}, bytes_of(std::string("C\0x", 3))));
  read_until_last();
  EXPECT_TRUE(others_.empty());
  const Refusals refusals = reader_->refusals();
  EXPECT_EQ(refusals.of(Refusal::beyond_end), 1);
  EXPECT_EQ(refusals.of(Refusal::bad_channel), 1);
  EXPECT_EQ(refusals.of(Refusal::contradiction), 1);
  EXPECT_EQ(refusals.malformed(), 3);
  EXPECT_EQ(refusals.foreign(), 0);
  EXPECT_THAT(refusals.text(), HasSubstr("3 malformed (fragments contradict each other)"));
}

TEST_F(UdpmReaderTest, HalfMessagesAreCounted) {
  listen(own_bus(default_lcm_url));
  const UdpSender sender;
  for (std::uint32_t sequence = 0; sequence < 10; ++sequence)
    sender.send(group, address_.port,
                testing::fragment_datagram({sequence, 100, 0, 0, 2}, bytes_of(std::string("C\0x", 3))));
  read_until_last();
  EXPECT_EQ(reader_->refusals().incomplete(), 6);  // four may still become whole
  EXPECT_EQ(reader_->refusals().malformed(), 0);
}

TEST_F(UdpmReaderTest, AnotherGroupOfTheSamePortIsAnotherBus) {
  const std::string url = own_bus(default_lcm_url);
  listen(url);
  std::string other = url;
  other.replace(other.find(group), std::string(group).size(), "239.255.76.68");
  const auto other_reader = LcmBus(other).listen(ChannelSet::matching(".*"));  // both groups are joined now
  UdpSender().send("239.255.76.68", address_.port, whole_datagram("THEIRS", {}));
  BusMessage message;
  ASSERT_TRUE(other_reader->read(message, seconds(20)));
  read_until_last();
  EXPECT_TRUE(others_.empty());
}

TEST_F(UdpmReaderTest, AFloodOfRefusedPacketsKeepsNobody) {
  listen(own_bus(default_lcm_url));
  std::atomic<bool> stop{false};
  std::thread flood([&] {
    const UdpSender sender;
    while (!stop) sender.send(group, address_.port, bytes_of("no datagram of LCM"));
  });
  BusMessage message;
  while (reader_->refusals().malformed() == 0) reader_->read(message, milliseconds(10));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(reader_->read(message, milliseconds(20)));
  EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(5));
  stop = true;
  flood.join();
}

TEST_F(UdpmReaderTest, WhatTheKernelDropsIsCounted) {
  listen(own_bus("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=20000"));
  EXPECT_EQ(reader_->socket().receive_buffer, 40'000);  // the kernel's account is twice what was asked for
  EXPECT_EQ(reader_->socket().kernel_drops, 0);
  const UdpSender sender;
  for (int i = 0; i < 100; ++i) sender.send(group, address_.port, whole_datagram("A", Bytes(10'000)));
  EXPECT_GT(reader_->socket().kernel_drops, 90);
}

TEST_F(UdpmReaderTest, ABusThatCannotBeJoinedIsSaid) {
  own_bus(default_lcm_url);
  try {
    const udpm::UdpmReader reader({"127.0.0.1", 7667, 0, 0}, ChannelSet({}), udpm::SourceFilter(0, {}));
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("cannot listen to 127.0.0.1:7667"));
  }
}

/// Another machine sends two packets by unicast, two by multicast; those that came through, and what was
/// refused.
struct Strangers : UdpmReaderTest {
  void attack(int ttl, const char* allowed) {
    const std::string url =
        own_bus("udpm://239.255.76.67:7667?recv_buf_size=200000&ttl=" + std::to_string(ttl));
    const auto neighbour = Neighbour::join();
    if (!neighbour) GTEST_SKIP() << "this machine permits no second network namespace";
    setenv("LCMSLAM_BUS_ALLOW", allowed, 1);
    listen(url);
    unsetenv("LCMSLAM_BUS_ALLOW");
    for (const std::string to : {Neighbour::own_address, group})
      for (const char* channel : {"A", "B"})
        neighbour->send(to, address_.port,
                        whole_datagram((to == group ? "GROUP_" : "UNICAST_") + std::string(channel), {}));
    // Unicast waits for the address on the wire, and may come last.
    const auto deadline = std::chrono::steady_clock::now() + seconds(20);
    BusMessage message;
    while (others_.size() + static_cast<std::size_t>(reader_->refusals().foreign()) < 4 &&
           std::chrono::steady_clock::now() < deadline)
      if (reader_->read(message, milliseconds(100))) others_.push_back(message.channel);
    read_until_last();  // this machine's own packets are taken always
  }
};

TEST_F(Strangers, AreNotHeardWithTtl0) {
  attack(0, "");
  if (IsSkipped()) return;
  EXPECT_TRUE(others_.empty());
  EXPECT_EQ(reader_->refusals().of(Refusal::foreign), 4);
  EXPECT_THAT(reader_->refusals().text(),
              HasSubstr(std::string("4 packets of strangers (last ") + Neighbour::address));
}

TEST_F(Strangers, SpeakThroughTheGroupAloneWithTtl1) {
  attack(1, "");
  if (IsSkipped()) return;
  EXPECT_THAT(others_, ::testing::ElementsAre("GROUP_A", "GROUP_B"));
  EXPECT_EQ(reader_->refusals().of(Refusal::foreign), 0);
  EXPECT_EQ(reader_->refusals().of(Refusal::not_group), 2);
}

TEST_F(Strangers, AreNotHeardWhereTheListNamesOthers) {
  attack(1, "10.76.67.3, 10.76.68.0/24");
  if (IsSkipped()) return;
  EXPECT_TRUE(others_.empty());
  EXPECT_EQ(reader_->refusals().of(Refusal::foreign), 4);
}

TEST_F(Strangers, AreHeardWhenTheListNamesThem) {
  attack(1, "10.76.67.0/30");
  if (IsSkipped()) return;
  EXPECT_THAT(others_, ::testing::ElementsAre("GROUP_A", "GROUP_B"));
}

}  // namespace
}  // namespace lcmslam
