// The queues between the bus and a node, over LCM's in-memory transport, and once over UDP multicast on
// a private bus.

#include <gmock/gmock.h>

#include <lcmslam/encoders_t.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/machine.hpp>
#include <lcmslam/runtime/status_reporter.hpp>
#include <lcmslam/runtime/udpm/multicast_address.hpp>
#include <lcmslam/status_t.hpp>
#include "tests/support/datagrams.hpp"
#include "tests/support/own_bus.hpp"

namespace lcmslam {
namespace {

using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;

encoders_t encoders(Utime utime) {
  encoders_t m;
  m.utime = utime;
  m.n_wheels = 0;
  return m;
}

class ReceiverTest : public ::testing::Test {
 protected:
  void subscribe(const std::string& channel, std::size_t capacity) {
    inputs_.subscribe<encoders_t>(channel, capacity,
                                  [this](const encoders_t& m) { handled_.push_back(m.utime); });
  }

  /// Waits until the receiving thread has seen everything up to a last message on a channel of its own.
  /// That one is the newest, so it stays behind all others.
  void drain(Receiver& receiver, LcmPublisher& publisher) {
    publisher.publish("LAST", encoders(-1));
    const auto deadline = std::chrono::steady_clock::now() + seconds(20);
    Arrival arrival;
    while (std::chrono::steady_clock::now() < deadline && receiver.take(arrival, seconds(5))) {
      arrival.deliver();
      if (arrival.input->channel() == "LAST") return;
    }
    FAIL() << "the last message did not arrive";
  }

  /// Lets the receiving thread work until `drops` messages were dropped in all.
  void wait_for_drops(Receiver& receiver, std::int64_t drops) {
    const auto deadline = std::chrono::steady_clock::now() + seconds(20);
    while (std::chrono::steady_clock::now() < deadline) {
      std::int64_t sum = 0;
      for (const auto& [input, count] : receiver.counts()) sum += count.drops;
      if (sum >= drops) return;
      std::this_thread::yield();
    }
    FAIL() << "fewer than " << drops << " messages were dropped";
  }

  Inputs inputs_;
  std::vector<Utime> handled_;
};

TEST_F(ReceiverTest, OldestAreDroppedAndCountedSoThatNothingIsTakenForLost) {
  LcmBus bus("memq://");
  ASSERT_TRUE(bus.usable());
  subscribe("IMAGES", 1);
  subscribe("ODOMETRY", 4);
  inputs_.subscribe<encoders_t>("LAST", 1, [](const encoders_t&) {});
  LcmPublisher publisher(bus.lcm(), 5, 1'000'000);
  // The first are taken at once, so that the numbering has begun.
  Receiver receiver(bus, inputs_);
  publisher.publish("IMAGES", encoders(0));
  publisher.publish("ODOMETRY", encoders(100));
  drain(receiver, publisher);
  EXPECT_THAT(handled_, ElementsAre(0, 100));
  handled_.clear();

  for (int i = 1; i <= 10; ++i) {
    publisher.publish("IMAGES", encoders(i));
    publisher.publish("ODOMETRY", encoders(100 + i));
  }
  wait_for_drops(receiver, 9 + 6);
  drain(receiver, publisher);
  EXPECT_THAT(handled_, ElementsAre(107, 108, 109, 10, 110));  // in the order of arrival, the latest wins
  const Input& images = *inputs_.all()[0];
  const Input& odometry = *inputs_.all()[1];
  EXPECT_EQ(receiver.counts().at(&images).drops, 9);
  EXPECT_EQ(receiver.counts().at(&odometry).drops, 6);
  EXPECT_EQ(images.senders.known().at(5).received, 2);
  EXPECT_EQ(images.senders.known().at(5).lost, 0);
  EXPECT_EQ(odometry.senders.known().at(5).received, 5);
  EXPECT_EQ(odometry.senders.known().at(5).lost, 0);
}

// A drop of one sender's message explains no gap of another's.
TEST_F(ReceiverTest, DropsOfTwoSendersAreKeptApart) {
  LcmBus bus("memq://");
  subscribe("IMAGES", 1);
  inputs_.subscribe<encoders_t>("LAST", 1, [](const encoders_t&) {});
  LcmPublisher publisher(bus.lcm(), 5, 1'000'000);
  Receiver receiver(bus, inputs_);
  const auto send = [&](std::int64_t sender, std::int64_t seq) {
    encoders_t m = encoders(seq);
    m.sender = sender;
    m.seq = seq;
    const auto bytes = encode_message(m);
    bus.lcm().publish("IMAGES", bytes.data(), static_cast<unsigned>(bytes.size()));
  };
  for (const std::int64_t sender : {1, 2}) {
    send(sender, 0);
    drain(receiver, publisher);
  }
  send(1, 1);
  send(2, 2);  // its 1 is lost, the other one's 1 is dropped
  wait_for_drops(receiver, 1);
  drain(receiver, publisher);
  send(1, 2);
  drain(receiver, publisher);
  const Input& images = *inputs_.all()[0];
  EXPECT_EQ(images.senders.known().at(1).lost, 0);
  EXPECT_EQ(images.senders.known().at(1).received, 2);
  EXPECT_EQ(images.senders.known().at(2).lost, 1);
  EXPECT_EQ(images.senders.known().at(2).received, 2);
}

TEST_F(ReceiverTest, ABusWithoutItsServerIsNotUsable) {
  LcmBus memory("memq://"), nobody("tcpq://127.0.0.1:1");
  EXPECT_TRUE(memory.usable());
  EXPECT_FALSE(nobody.usable());
}

TEST_F(ReceiverTest, NothingToTakeIsSaid) {
  LcmBus bus("memq://");
  subscribe("IMAGES", 1);
  Receiver receiver(bus, inputs_);
  Arrival arrival;
  EXPECT_FALSE(receiver.take(arrival, std::chrono::milliseconds(1)));
}

TEST_F(ReceiverTest, AnotherReceiverCanFollowOnTheSameBus) {
  LcmBus bus("memq://");
  subscribe("IMAGES", 10);
  inputs_.subscribe<encoders_t>("LAST", 1, [](const encoders_t&) {});
  LcmPublisher publisher(bus.lcm(), 5, 1'000'000);
  for (int round = 0; round < 2; ++round) {
    Receiver receiver(bus, inputs_);
    publisher.publish("IMAGES", encoders(round));
    drain(receiver, publisher);
  }
  EXPECT_THAT(handled_, ElementsAre(0, 1));
}

TEST_F(ReceiverTest, MessagesOfEverySizeCrossAPrivateBus) {
  const std::string url = own_bus("udpm://239.255.76.67:7667?ttl=0");
  LcmBus sending(url), receiving(url);
  ASSERT_TRUE(sending.usable() && receiving.usable());
  std::vector<std::size_t> sizes;
  inputs_.subscribe<encoders_t>("BIG", 10, [&](const encoders_t& m) { sizes.push_back(m.wheels.size()); });
  inputs_.subscribe<encoders_t>("LAST", 1, [](const encoders_t&) {});
  Receiver receiver(receiving, inputs_);
  LcmPublisher publisher(sending.lcm(), 6, 1'000'000);
  for (const std::size_t wheels : {0U, 20U, 1250U}) {  // up to 60 kB: fragmented
    encoders_t m = encoders(static_cast<Utime>(wheels));
    m.wheels.resize(wheels);
    m.n_wheels = static_cast<int>(wheels);
    publisher.publish("BIG", m);
  }
  drain(receiver, publisher);
  EXPECT_THAT(sizes, ElementsAre(0, 20, 1250));
  EXPECT_EQ(inputs_.all()[0]->senders.known().at(6).lost, 0);
}

TEST_F(ReceiverTest, BigMessagesCrossInPieces) {
  // The buffer that every kernel grants holds all pieces of one message, however late they are read.
  const std::string url = own_bus("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=212992");
  LcmBus sending(url), receiving(url);
  ASSERT_TRUE(sending.usable() && receiving.usable());
  std::vector<std::string> details;
  inputs_.subscribe<status_t>("BIG", 100, [&](const status_t& m) { details.push_back(m.detail); });
  inputs_.subscribe<encoders_t>("LAST", 1, [](const encoders_t&) {});
  Receiver receiver(receiving, inputs_);
  LcmPublisher publisher(sending.lcm(), 6, 0);
  std::vector<std::string> sent;
  for (std::size_t i = 0; i < 10; ++i) {
    sent.emplace_back(59'000 + i * 24'000, static_cast<char>('a' + i));
    status_t m{};
    m.detail = sent.back();
    publisher.publish("BIG", m);
    drain(receiver, publisher);
  }
  EXPECT_THAT(details, ElementsAreArray(sent));
  EXPECT_EQ(inputs_.all()[0]->senders.known().at(6).lost, 0);
  EXPECT_EQ(publisher.split(), 9);
}

TEST_F(ReceiverTest, WhoSendsALargeMessageDoesNotWaitForItsPieces) {
  LcmBus bus("memq://");
  std::vector<std::size_t> sizes;
  std::vector<std::string> channels;
  for (const char* channel : {"BIG", "OTHER"})
    inputs_.subscribe<status_t>(channel, 100, [&, channel](const status_t& m) {
      sizes.push_back(m.detail.size());
      channels.emplace_back(channel);
    });
  Receiver receiver(bus, inputs_);
  status_t big{}, small{};
  big.detail.assign(12'000'000, 'x');
  small.detail = "x";
  {
    LcmPublisher publisher(bus.lcm(), 6, 100'000);
    const auto begin = std::chrono::steady_clock::now();
    publisher.publish("BIG", big);  // 200 pieces, 3 ms each
    publisher.publish("BIG", small);
    publisher.publish("OTHER", small);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    EXPECT_LT(took.count(), 0.4);
  }
  Arrival arrival;
  while (sizes.size() < 3 && receiver.take(arrival, seconds(20))) arrival.deliver();
  EXPECT_THAT(sizes, ElementsAre(1, big.detail.size(), 1)) << "all of it is out";
  EXPECT_THAT(channels, ElementsAre("OTHER", "BIG", "BIG")) << "in the order of its channel";
  EXPECT_EQ(inputs_.all()[0]->senders.known().at(6).lost, 0);
}

TEST_F(ReceiverTest, HalfMessagesOfAllChannelsAreBoundedAndWhoHasMostPays) {
  setenv("LCMSLAM_BUS_MEMORY", "16", 1);
  LcmBus bus("memq://");
  std::size_t handled = 0;
  for (const char* channel : {"A", "B"})
    inputs_.subscribe<status_t>(channel, 10, [&](const status_t& m) { handled += m.detail.size(); });
  inputs_.subscribe<encoders_t>("LAST", 1, [](const encoders_t&) {});
  Receiver receiver(bus, inputs_);
  unsetenv("LCMSLAM_BUS_MEMORY");
  const auto send = [&](const part_t& part) {
    const auto bytes = encode_message(part);
    bus.lcm().publish(part_channel(part.channel), bytes.data(), static_cast<unsigned>(bytes.size()));
  };
  status_t big{};
  big.detail.assign(9'500'000, 'x');
  const auto of_a = split_message("A", encode_message(big), 1, 0, 1'000'000);
  const auto of_b = split_message("B", encode_message(big), 1, 0, 1'000'000);
  for (const auto* parts : {&of_a, &of_b})
    for (std::size_t i = 0; i + 1 < parts->size(); ++i) send((*parts)[i]);
  send(of_b.back());
  LcmPublisher publisher(bus.lcm(), 5, 1'000'000);
  drain(receiver, publisher);
  EXPECT_EQ(handled, big.detail.size());
  EXPECT_EQ(receiver.counts().at(inputs_.all()[0].get()).incomplete, 1);
  EXPECT_EQ(receiver.counts().at(inputs_.all()[1].get()).incomplete, 0);
}

TEST_F(ReceiverTest, AMessageInPiecesTakesAsMuchAsAllMay) {
  setenv("LCMSLAM_BUS_MEMORY", "40", 1);
  LcmBus bus("memq://");
  std::size_t handled = 0;
  inputs_.subscribe<status_t>("A", 10, [&](const status_t& m) { handled += m.detail.size(); });
  inputs_.subscribe<encoders_t>("LAST", 1, [](const encoders_t&) {});
  Receiver receiver(bus, inputs_);
  unsetenv("LCMSLAM_BUS_MEMORY");
  status_t big{};
  big.detail.assign(std::size_t{39} << 20, 'x');
  for (const part_t& part : split_message("A", encode_message(big), 1, 0, 4 << 20)) {
    const auto bytes = encode_message(part);
    bus.lcm().publish("A_PART", bytes.data(), static_cast<unsigned>(bytes.size()));
  }
  LcmPublisher publisher(bus.lcm(), 5, 1'000'000);
  drain(receiver, publisher);
  EXPECT_EQ(handled, big.detail.size());
}

TEST_F(ReceiverTest, WhatAProcessComputedBeforeItReportsIsNotOfItsFirstMoment) {
  LcmBus bus("memq://");
  Receiver receiver(bus, inputs_);
  LcmPublisher publisher(bus.lcm(), 5, 1'000'000);
  const auto compute = [](double seconds) {
    const double end = process_cpu_seconds() + seconds;
    while (process_cpu_seconds() < end) {
    }
  };
  compute(0.5);
  StatusReporter reporter("x", publisher);
  compute(0.1);
  EXPECT_LT(reporter.gather({}, inputs_, receiver).cpu, 3);
}

TEST_F(ReceiverTest, WhatNobodyShouldHaveSentIsCountedTogether) {
  const std::string url = own_bus("udpm://239.255.76.67:7667?ttl=0");
  LcmBus sending(url), receiving(url);
  ASSERT_TRUE(sending.usable() && receiving.usable());
  subscribe("IMAGES", 1);
  inputs_.subscribe<encoders_t>("LAST", 1, [](const encoders_t&) {});
  Receiver receiver(receiving, inputs_);
  LcmPublisher publisher(sending.lcm(), 6, 1'000'000);
  drain(receiver, publisher);
  EXPECT_EQ(receiver.refused(), 0);
  sending.lcm().publish("IMAGES_PART", "no part", 7);
  const MulticastAddress address = multicast_address(url);
  testing::UdpSender().send(address.group, address.port, testing::bytes_of("no datagram of LCM"));
  drain(receiver, publisher);
  EXPECT_EQ(receiver.refused(), 2);
}

// With a receive buffer that cannot hold what comes, messages are lost; each of them is counted.
TEST_F(ReceiverTest, EveryLostMessageIsCounted) {
  const std::string url = own_bus("udpm://239.255.76.67:7667?ttl=0");
  LcmBus sending(url), receiving(url + "&recv_buf_size=40000");
  ASSERT_TRUE(sending.usable() && receiving.usable());
  inputs_.subscribe<encoders_t>("BIG", 1000, [&](const encoders_t& m) { handled_.push_back(m.utime); });
  Receiver receiver(receiving, inputs_);
  LcmPublisher publisher(sending.lcm(), 6, 1'000'000);
  const Input& big = *inputs_.all()[0];

  // The first and the last arrive: they are repeated until one is seen.
  Arrival arrival;
  const auto send_until_seen = [&](Utime utime) {
    for (int tries = 0; tries < 1000; ++tries) {
      publisher.publish("BIG", encoders(utime));
      while (receiver.take(arrival, std::chrono::milliseconds(20))) arrival.deliver();
      if (!handled_.empty() && handled_.back() == utime) return true;
    }
    return false;
  };
  ASSERT_TRUE(send_until_seen(-1));
  encoders_t m = encoders(0);
  m.wheels.resize(600);  // 29 kB
  m.n_wheels = 600;
  // A reader that has a processor to itself may keep up for a while.
  const auto deadline = std::chrono::steady_clock::now() + seconds(20);
  while (receiver.socket().kernel_drops == 0 && std::chrono::steady_clock::now() < deadline) {
    for (m.utime = 0; m.utime < 100; ++m.utime) publisher.publish("BIG", m);
    while (receiver.take(arrival, seconds(0))) arrival.deliver();
  }
  ASSERT_TRUE(send_until_seen(-2));
  const InputCount& count = big.senders.known().at(6);
  EXPECT_EQ(count.received, static_cast<std::int64_t>(handled_.size()));
  EXPECT_GT(count.lost, 0);
  EXPECT_EQ(publisher.counts().at("BIG").sent, count.received + count.lost);
}

TEST(LargestWholeMessage, FollowsTheGrantedBuffer) {
  const std::size_t small = largest_whole_message("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=100000");
  EXPECT_EQ(small, 50'000u);  // the kernel reports twice what was asked for, a quarter of it is trusted
  EXPECT_GE(largest_whole_message("udpm://239.255.76.67:7667?ttl=0"), 16'384u);
  EXPECT_GT(largest_whole_message("memq://"), std::size_t{1} << 30);
}

TEST(Sender, IsNeverZeroAndDiffers) {
  const std::int64_t a = draw_sender(), b = draw_sender();
  EXPECT_GT(a, 0);
  EXPECT_GT(b, 0);
  EXPECT_NE(a, b);
}

}  // namespace
}  // namespace lcmslam
