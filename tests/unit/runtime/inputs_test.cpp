#include <lcmslam/runtime/inputs.hpp>

#include <gmock/gmock.h>

#include <spdlog/spdlog.h>

#include <lcmslam/command_t.hpp>
#include <lcmslam/encoders_t.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/pose_t.hpp>

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

std::vector<std::uint8_t> message(std::int64_t seq, std::int64_t sender = 7, Utime utime = 1000) {
  encoders_t m;
  m.utime = utime;
  m.seq = seq;
  m.sender = sender;
  m.n_wheels = 0;
  return encode_message(m);
}

TEST(InputCount, CountsAGapOnceAndTakesItBackWhenTheMessageComesLate) {
  InputCount count;
  for (const int seq : {5, 6, 9}) count.follow(seq);
  EXPECT_EQ(count.lost, 2);  // 7 and 8; what came before the first is none of ours
  count.follow(7);
  EXPECT_EQ(count.lost, 1);
  EXPECT_EQ(count.reordered, 1);
  EXPECT_EQ(count.last_seq, 9);
  count.follow(9);
  EXPECT_EQ(count.duplicates, 1);
  EXPECT_EQ(count.lost, 1);
}

TEST(InputCount, AMessageThatComesTwiceIsNoDisorderHoweverLateItComes) {
  InputCount count;
  for (const int seq : {1, 2, 3, 2}) count.follow(seq);
  EXPECT_EQ(count.duplicates, 1);
  EXPECT_EQ(count.reordered, 0);
  for (const int seq : {6, 2, 4, 4}) count.follow(seq);
  EXPECT_EQ(count.lost, 1);  // 5
  EXPECT_EQ(count.duplicates, 3);
  EXPECT_EQ(count.reordered, 1);
}

TEST(InputCount, ALogThatIsPlayedAgainIsNoDisorderAndItsLossesCount) {
  InputCount count;
  for (int round = 0; round < 3; ++round)
    for (int seq = 0; seq < 40; ++seq)
      if (round == 0 || seq != 20) count.follow(seq, 0, 100'000'000 + seq * 100'000);
  EXPECT_EQ(count.lost, 2);
  EXPECT_EQ(count.duplicates, 0);
  EXPECT_EQ(count.reordered, 0);
}

TEST(InputCount, SenderThatDoesNotNumberLosesNothing) {
  InputCount count;
  for (int i = 0; i < 3; ++i) count.follow(-1);
  EXPECT_EQ(count.lost + count.duplicates + count.reordered, 0);
}

TEST(InputCount, KnownMissingMessagesAreNotLost) {
  InputCount count;
  count.follow(0);
  count.follow(5, 3);
  EXPECT_EQ(count.lost, 1);
  count.follow(6, 2);  // more were thrown away than are missing: duplicates
  EXPECT_EQ(count.lost, 1);
}

/// Thousands of bad messages are expected: they need not be shown.
class Accounting : public ::testing::Test {
 protected:
  void SetUp() override { spdlog::set_level(spdlog::level::off); }
  void TearDown() override { spdlog::set_level(spdlog::level::info); }
};

/// Everything that was sent is received, lost, dropped or malformed, and nothing is two of them.
TEST_F(Accounting, CountsEveryMessageExactlyOnce) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    Inputs inputs;
    Input& input = inputs.subscribe<encoders_t>("ENCODERS", 10, [](const encoders_t&) {});
    const std::int64_t sent = 300;
    std::int64_t lost = 0, dropped = 0, malformed = 0, repeated = 0, received = 0, waiting_drops = 0;
    for (std::int64_t seq = 0; seq < sent; ++seq) {
      const bool at_an_end = seq == 0 || seq + 1 == sent;  // losses there cannot be seen in the numbers
      auto bytes = message(seq);
      const std::uint64_t fate = at_an_end ? 9 : random.below(10);
      if (fate < 2) {
        ++lost;
      } else if (fate == 2) {
        ++dropped;
        ++waiting_drops;
      } else if (fate == 3) {
        ++malformed;
        bytes.resize(random.below(bytes.size()));
        input.deliver(bytes.data(), bytes.size(), waiting_drops);
        waiting_drops = 0;
      } else {
        const std::int64_t times = random.below(5) == 0 ? 2 : 1;
        for (std::int64_t k = 0; k < times; ++k) {
          input.deliver(bytes.data(), bytes.size(), waiting_drops);
          waiting_drops = 0;
        }
        repeated += times - 1;
        received += times;
      }
    }
    const InputCount& count = input.senders.known().at(7);
    EXPECT_EQ(count.received, received) << "seed " << seed;
    EXPECT_EQ(count.lost, lost) << "seed " << seed;
    EXPECT_EQ(count.duplicates, repeated) << "seed " << seed;
    EXPECT_EQ(input.decode_errors, malformed) << "seed " << seed;
    EXPECT_EQ(count.reordered, 0) << "seed " << seed;
    EXPECT_EQ(sent, count.received - count.duplicates + count.lost + dropped + input.decode_errors)
        << "seed " << seed;
  }
}

TEST(Inputs, NeighboursThatChangePlacesAreNotLost) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    std::vector<std::int64_t> order(100);
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int64_t>(i);
    std::int64_t swaps = 0;
    for (std::size_t i = 1; i + 1 < order.size(); i += 2) {
      if (random.below(3) != 0) continue;
      std::swap(order[i], order[i + 1]);
      ++swaps;
    }
    InputCount count;
    for (const std::int64_t seq : order) count.follow(seq);
    EXPECT_EQ(count.reordered, swaps);
    EXPECT_EQ(count.lost, 0);
  }
}

TEST(Inputs, SendersAreCountedApartSoThatARestartIsNoLoss) {
  Inputs inputs;
  Input& input = inputs.subscribe<encoders_t>("ENCODERS", 10, [](const encoders_t&) {});
  for (const auto& bytes : {message(100, 1), message(101, 1), message(0, 2), message(1, 2)})
    input.deliver(bytes.data(), bytes.size());
  ASSERT_EQ(input.senders.known().size(), 2U);
  for (const auto& [sender, count] : input.senders.known()) {
    EXPECT_EQ(count.received, 2);
    EXPECT_EQ(count.lost, 0);
  }
  EXPECT_EQ(input.senders.known().at(2).last_seq, 1);
}

TEST(Inputs, ManyForgedSendersDoNotGrowTheTableForEver) {
  Inputs inputs;
  Input& input = inputs.subscribe<encoders_t>("ENCODERS", 10, [](const encoders_t&) {});
  for (std::int64_t sender = 1; sender <= 1000; ++sender) {
    const auto bytes = message(0, sender);
    input.deliver(bytes.data(), bytes.size());
  }
  EXPECT_LE(input.senders.known().size(), 65U);
  EXPECT_LE(input.senders.table().size(), 65U);
  EXPECT_EQ(input.senders.total().received, 1000);
}

TEST(Inputs, BadMessagesAreCountedAndTheNextOneIsHandled) {
  Inputs inputs;
  int handled = 0;
  Input& input = inputs.subscribe<encoders_t>("ENCODERS", 10, [&](const encoders_t& m) {
    if (m.utime < 0) throw DecodeError("utime is negative");
    ++handled;
  });
  const auto good = message(0), wrong_value = message(1, 7, -5);
  pose_t pose{};
  const auto wrong_type = encode_message(pose);
  EXPECT_TRUE(inputs.deliver("ENCODERS", good.data(), good.size()));
  EXPECT_TRUE(inputs.deliver("ENCODERS", wrong_type.data(), wrong_type.size()));
  EXPECT_THAT(input.last_error, HasSubstr("but a pose_t"));
  EXPECT_TRUE(inputs.deliver("ENCODERS", wrong_value.data(), wrong_value.size()));
  EXPECT_EQ(input.last_error, "utime is negative");
  EXPECT_TRUE(inputs.deliver("ENCODERS", nullptr, 0));
  const auto last = message(2);
  EXPECT_TRUE(inputs.deliver("ENCODERS", last.data(), last.size()));
  EXPECT_EQ(handled, 2);
  EXPECT_EQ(input.decode_errors, 3);
  EXPECT_EQ(input.senders.known().at(7).received, 2);  // five came: none is counted twice
  EXPECT_EQ(input.senders.known().at(7).lost, 0);
}

TEST(Inputs, AnErrorThatRepeatsTheMessageIsCutAndHoldsNoControlCharacters) {
  Inputs inputs;
  Input& input = inputs.subscribe<encoders_t>("ENCODERS", 10, [](const encoders_t&) {
    throw DecodeError("sensor '\x1b[31m" + std::string(5'000'000, 'A'));
  });
  const auto bytes = message(0);
  inputs.deliver("ENCODERS", bytes.data(), bytes.size());
  EXPECT_THAT(input.last_error, ::testing::StartsWith("sensor '\\x1b[31mAAA"));
  EXPECT_LT(input.last_error.size(), 300U);
}

TEST(Inputs, TimesThatAreNoneAreRefused) {
  Inputs inputs;
  int handled = 0;
  Input& input = inputs.subscribe<encoders_t>("ENCODERS", 10, [&](const encoders_t&) { ++handled; });
  constexpr Utime far = 100'000'000'000'000'000;  // us
  for (const Utime utime : {far, -far, far + 1, -far - 1, std::numeric_limits<Utime>::min()}) {
    const auto bytes = message(0, 7, utime);
    inputs.deliver("ENCODERS", bytes.data(), bytes.size());
  }
  EXPECT_EQ(handled, 2);
  EXPECT_EQ(input.decode_errors, 3);
  EXPECT_THAT(input.last_error, HasSubstr("is no time"));
}

TEST(Inputs, EveryHandlerOfAChannelHearsTheMessageAndNobodyElse) {
  Inputs inputs;
  int first = 0, second = 0, other = 0;
  inputs.subscribe<encoders_t>("A", 1, [&](const encoders_t&) { ++first; });
  inputs.subscribe<encoders_t>("A", 1, [&](const encoders_t&) { ++second; });
  inputs.subscribe<encoders_t>("AB", 1, [&](const encoders_t&) { ++other; });
  const auto bytes = message(0);
  EXPECT_TRUE(inputs.deliver("A", bytes.data(), bytes.size()));
  EXPECT_FALSE(inputs.deliver("B", bytes.data(), bytes.size()));
  EXPECT_EQ(first, 1);
  EXPECT_EQ(second, 1);
  EXPECT_EQ(other, 0);
}

TEST(Inputs, HandlersOfMeasurementsSeeOnePublisherAndTimeThatGoesOn) {
  Inputs inputs;
  std::vector<Utime> handled;
  int sessions = 0;
  inputs.on_new_session = [&] { ++sessions; };
  Input& input = inputs.subscribe_measured<encoders_t>(
      "ENCODERS", 10, [&](const encoders_t& m) { handled.push_back(m.utime); });
  std::int64_t seq = 0;
  const auto deliver = [&](Utime utime, std::int64_t sender = 7) {
    const auto bytes = message(seq++, sender, utime);
    inputs.deliver("ENCODERS", bytes.data(), bytes.size());
  };
  constexpr Utime start = 1'000'000'000, step = 100'000;
  for (int i = 0; i < 5; ++i) {
    deliver(start + i * step);
    deliver(start + i * step);               // twice
    deliver(start + i * step + 10'000'000);  // wrong
    deliver(start + i * step + 50'000, 99);  // of another
  }
  EXPECT_THAT(handled, ::testing::ElementsAre(start, start + step, start + 2 * step, start + 3 * step,
                                              start + 4 * step));
  EXPECT_EQ(inputs.stamps().refused(), 5);
  EXPECT_EQ(inputs.stamps().foreign(), 5);
  EXPECT_EQ(input.senders.known().at(7).received, 15) << "all are counted";
  EXPECT_EQ(inputs.refused(), 10);
  inputs.deliver("ENCODERS", nullptr, 0);
  EXPECT_EQ(inputs.refused(), 11);
  EXPECT_EQ(sessions, 0);
  handled.clear();
  for (int i = 0; i < 10; ++i) deliver(5'000'000 + i * step);
  EXPECT_EQ(sessions, 1);
  ASSERT_GE(handled.size(), 4U);
  EXPECT_LT(handled.front(), start);
}

TEST(Inputs, ForeignTypesWithoutNumbersAreReceived) {
  Inputs inputs;
  Input& input = inputs.subscribe<pose_t>("POSE_BODY", 1, [](const pose_t&) {});
  pose_t pose{};
  pose.utime = 12;
  const auto bytes = encode_message(pose);
  for (int i = 0; i < 3; ++i) input.deliver(bytes.data(), bytes.size());
  EXPECT_EQ(input.senders.known().at(0).received, 3);
  EXPECT_EQ(input.senders.known().at(0).last_utime, 12);
  EXPECT_EQ(input.senders.known().at(0).lost, 0);
}

}  // namespace
}  // namespace lcmslam
