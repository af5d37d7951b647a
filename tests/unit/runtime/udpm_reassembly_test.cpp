// Messages from their fragments: whole ones come out byte for byte, half ones take bounded room.

#include <gmock/gmock.h>

#include <numeric>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/runtime/udpm/reassembly.hpp>

namespace lcmslam::udpm {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Bytes = std::vector<std::uint8_t>;

const Source here{1, 1};

/// A message cut into packets that look into its bytes.
struct Message {
  std::uint32_t sequence;
  std::string channel;
  Bytes bytes;
  std::uint16_t count;

  Packet packet(std::uint16_t number) const {
    const std::size_t part = bytes.size() / count;
    Packet packet;
    packet.sequence = sequence;
    if (number == 0) packet.channel = channel;
    packet.message_size = bytes.size();
    packet.offset = number * part;
    packet.data = bytes.data() + packet.offset;
    packet.size = number + 1 == count ? bytes.size() - packet.offset : part;
    packet.number = number;
    packet.count = count;
    return packet;
  }
};

Message message(std::uint32_t sequence, std::size_t size = 1000, std::uint16_t count = 3,
                const std::string& channel = "CAMERA") {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i * 31 + sequence);
  return {sequence, channel, bytes, count};
}

class ReassemblyTest : public ::testing::Test {
 protected:
  void make(ReassemblyLimits limits = {}) {
    reassembly_.emplace([](const std::string& channel) { return channel != "UNWANTED"; }, limits);
    reassembly_->on_refusal = [this](Refusal why) { refused_.push_back(why); };
  }
  /// What came out last of these fragments.
  std::optional<BusMessage> add(const Message& m, const std::vector<std::uint16_t>& numbers,
                                const Source& source = here) {
    std::optional<BusMessage> whole;
    for (const std::uint16_t number : numbers) whole = reassembly_->add(source, m.packet(number));
    return whole;
  }
  static void expect_whole(const std::optional<BusMessage>& whole, const Message& m) {
    ASSERT_TRUE(whole.has_value());
    EXPECT_EQ(whole->channel, m.channel);
    EXPECT_EQ(whole->bytes, m.bytes);
  }
  void expect_empty() const {
    EXPECT_EQ(reassembly_->waiting_messages(), 0U);
    EXPECT_EQ(reassembly_->waiting_bytes(), 0U);
  }

  void SetUp() override { make(); }
  std::optional<Reassembly> reassembly_;
  std::vector<Refusal> refused_;
};

TEST_F(ReassemblyTest, EveryOrderGivesTheSameBytes) {
  std::vector<std::uint16_t> order = {0, 1, 2, 3};
  do {
    const Message m = message(9, 1001, 4);
    EXPECT_FALSE(add(m, {order[0], order[1], order[2]}));
    expect_whole(add(m, {order[3]}), m);
    expect_empty();
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_THAT(refused_, IsEmpty());
}

TEST_F(ReassemblyTest, SendersAndTheirMessagesAreKeptApart) {
  const Source other_port{1, 2}, other_address{2, 1};
  const Message a = message(1), b = message(2);
  Message c = message(1);
  c.bytes.assign(c.bytes.size(), 'c');
  Message d = c;
  d.bytes.assign(d.bytes.size(), 'd');
  for (std::uint16_t number = 0; number < 2; ++number) {
    add(a, {number});
    add(b, {number});
    add(c, {number}, other_port);
    add(d, {number}, other_address);
  }
  EXPECT_EQ(reassembly_->waiting_messages(), 4U);
  expect_whole(add(c, {2}, other_port), c);
  expect_whole(add(a, {2}), a);
  expect_whole(add(d, {2}, other_address), d);
  expect_whole(add(b, {2}), b);
  EXPECT_THAT(refused_, IsEmpty());
}

TEST_F(ReassemblyTest, AFragmentThatComesTwiceCountsOnceAndTheNewerHolds) {
  const Message old = message(1);
  Message fresh = message(1);
  fresh.bytes.assign(fresh.bytes.size(), 'f');
  EXPECT_FALSE(add(old, {0, 1, 1, 0, 1}));
  const std::size_t waiting = reassembly_->waiting_bytes();
  EXPECT_FALSE(add(fresh, {0, 1}));
  EXPECT_EQ(reassembly_->waiting_bytes(), waiting);
  expect_whole(add(fresh, {2}), fresh);
  expect_empty();
}

TEST_F(ReassemblyTest, OtherChannelsAreNotKept) {
  const Message early = message(1, 90'000, 3, "UNWANTED");
  add(early, {1});  // nobody knows yet whose it is
  EXPECT_GT(reassembly_->waiting_bytes(), 30'000U);
  add(early, {0});
  EXPECT_LT(reassembly_->waiting_bytes(), 1000U);
  EXPECT_FALSE(add(early, {2}));
  expect_empty();
  add(message(2, 90'000, 3, "UNWANTED"), {0, 1});  // the third is lost
  for (std::uint32_t sequence = 3; sequence < 10; ++sequence) add(message(sequence), {0, 1, 2});
  for (std::uint32_t sequence = 10; sequence < 14; ++sequence) add(message(sequence), {0});
  EXPECT_THAT(refused_, IsEmpty()) << "what nobody wants is not missed";
}

TEST_F(ReassemblyTest, FragmentsThatDisagreeBeginAnew) {
  const Message m = message(1);
  add(message(1, 999), {0, 1});
  EXPECT_FALSE(add(m, {0}));
  EXPECT_THAT(refused_, ElementsAre(Refusal::contradiction));
  add(message(1, 1000, 4), {0});
  EXPECT_THAT(refused_, ElementsAre(Refusal::contradiction, Refusal::contradiction));
  EXPECT_EQ(reassembly_->waiting_messages(), 1U);
  expect_whole(add(m, {0, 1, 2}), m);
}

TEST_F(ReassemblyTest, FragmentsMustTileTheirMessage) {
  const Message m = message(1, 999, 3);
  for (const int shift : {-333, -1, 1}) {  // over the first, into the first, a hole
    Packet shifted = m.packet(1);
    shifted.offset = static_cast<std::size_t>(static_cast<int>(shifted.offset) + shift);
    add(m, {0, 2});
    EXPECT_FALSE(reassembly_->add(here, shifted)) << shift;
    expect_empty();
  }
  Packet last = m.packet(2);  // the end is missing
  last.size -= 1;
  add(m, {0, 1});
  EXPECT_FALSE(reassembly_->add(here, last));
  EXPECT_THAT(refused_, ElementsAre(Refusal::contradiction, Refusal::contradiction, Refusal::contradiction,
                                    Refusal::contradiction));
}

TEST_F(ReassemblyTest, ASenderGivesUpItsOldestHalfMessage) {
  for (std::uint32_t sequence = 0; sequence < 5; ++sequence) add(message(sequence), {0, 1});
  EXPECT_THAT(refused_, ElementsAre(Refusal::incomplete));
  EXPECT_EQ(reassembly_->waiting_messages(), 4U);
  EXPECT_FALSE(add(message(0), {2}));  // this one was given up; now it displaces 1
  for (const std::uint32_t sequence : {2U, 3U, 4U})
    expect_whole(add(message(sequence), {2}), message(sequence));
}

TEST_F(ReassemblyTest, NumberOfHalfMessagesIsBounded) {
  for (std::uint32_t address = 1; address <= 10'000; ++address)
    add(message(1), {0}, {address, static_cast<std::uint16_t>(address)});
  EXPECT_EQ(reassembly_->waiting_messages(), ReassemblyLimits().messages);
  EXPECT_EQ(refused_.size(), 10'000 - ReassemblyLimits().messages);
  const Source newest{10'000, 10'000};
  expect_whole(add(message(1), {1, 2}, newest), message(1));
}

TEST_F(ReassemblyTest, MemoryOfHalfMessagesIsBounded) {
  const Message big = message(1, 4 << 20, 100);
  std::vector<std::uint16_t> all_but_one(99);
  std::iota(all_but_one.begin(), all_but_one.end(), std::uint16_t{0});
  for (std::uint32_t address = 1; address <= 20; ++address) {
    add(big, all_but_one, {address, 0});
    EXPECT_LE(reassembly_->waiting_bytes(), ReassemblyLimits().bytes);
  }
  EXPECT_THAT(reassembly_->waiting_messages(), ::testing::AllOf(::testing::Ge(6U), ::testing::Le(8U)));
  expect_whole(add(big, {99}, {20, 0}), big);
}

TEST_F(ReassemblyTest, SmallFragmentsCostWhatTheyTakeToKeep) {
  make({1'000'000, 1000, 1000});
  for (std::uint32_t address = 1; address <= 20; ++address)
    for (std::uint16_t number = 0; number < 1000; ++number)
      reassembly_->add({address, 0}, message(1, 1000, 1000).packet(number == 0 ? 1 : number));
  EXPECT_LE(reassembly_->waiting_messages(), 8U);  // 999 bytes each, but 999 pieces of memory
}

TEST_F(ReassemblyTest, AnnouncedSizesTakeNoMemory) {
  Message m = message(1);
  Packet packet = m.packet(0);
  packet.message_size = largest_message;
  for (std::uint32_t address = 1; address <= 256; ++address) reassembly_->add({address, 0}, packet);
  EXPECT_EQ(reassembly_->waiting_messages(), 256U);
  EXPECT_LT(reassembly_->waiting_bytes(), 256U * 1000U);
}

TEST_F(ReassemblyTest, RandomTrafficWithLossComesOutWholeOrNotAtAll) {
  Random random(20260);
  std::size_t whole = 0, sent = 0;
  std::vector<std::pair<Message, std::uint16_t>> traffic;
  for (std::uint32_t sequence = 0; sequence < 500; ++sequence) {
    const auto count = static_cast<std::uint16_t>(1 + random.below(8));
    const Message m = message(sequence, 9 + random.below(5000), count);
    if (m.count < 2) continue;
    ++sent;
    for (std::uint16_t number = 0; number < m.count; ++number)
      if (random.below(20) > 0) traffic.push_back({m, number});
  }
  for (std::size_t i = 1; i < traffic.size(); ++i)  // neighbours change places
    if (random.below(3) == 0) std::swap(traffic[i - 1], traffic[i]);
  for (const auto& [m, number] : traffic)
    if (const auto out = reassembly_->add(here, m.packet(number))) {
      EXPECT_EQ(out->bytes, m.bytes);
      ++whole;
    }
  EXPECT_GT(whole, sent / 2);
  EXPECT_LT(whole, sent);
  EXPECT_LE(reassembly_->waiting_messages(), 4U);
}

TEST(ReassemblyLimitsTest, AreTheEnvironments) {
  EXPECT_EQ(reassembly_limits().bytes, 32U << 20U);
  setenv("LCMSLAM_BUS_MEMORY", "64", 1);
  EXPECT_EQ(reassembly_limits().bytes, 64U << 20U);
  EXPECT_EQ(reassembly_limits().messages, 512U);
  for (const char* wrong : {"15", "4097", "-1", "64MB", "99999999999999999999"}) {
    setenv("LCMSLAM_BUS_MEMORY", wrong, 1);
    EXPECT_THAT([] { reassembly_limits(); },
                ::testing::ThrowsMessage<std::invalid_argument>(::testing::HasSubstr("16 to 4096")))
        << wrong;
  }
  unsetenv("LCMSLAM_BUS_MEMORY");
}

}  // namespace
}  // namespace lcmslam::udpm
