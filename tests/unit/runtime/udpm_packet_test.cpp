// Every claim of a datagram about itself is checked.

#include <gmock/gmock.h>

#include <lcmslam/runtime/udpm/packet.hpp>
#include "tests/support/datagrams.hpp"

namespace lcmslam::udpm {
namespace {

using lcmslam::testing::Bytes;
using lcmslam::testing::bytes_of;
using lcmslam::testing::fragment_datagram;
using lcmslam::testing::FragmentHeader;
using lcmslam::testing::whole_datagram;

/// In memory of exactly that size, so that sanitizers see whoever reads on.
std::variant<Packet, Refusal> parse(Bytes bytes) {
  static Bytes kept;  // the packet looks into it
  kept = std::move(bytes);
  kept.shrink_to_fit();
  return parse_packet(kept.data(), kept.size());
}

std::string data_of(const Packet& packet) {
  return {packet.data, packet.data + packet.size};
}

void expect_refused(const Bytes& bytes, Refusal why) {
  const auto parsed = parse(bytes);
  if (std::holds_alternative<Packet>(parsed))
    ADD_FAILURE() << "taken, not refused as: " << describe(why);
  else
    EXPECT_STREQ(describe(std::get<Refusal>(parsed)), describe(why));
}

TEST(Packet, AWholeMessageIsRead) {
  const auto parsed = parse(whole_datagram("CAMERA", bytes_of("data"), 0x01020304));
  ASSERT_TRUE(std::holds_alternative<Packet>(parsed));
  const Packet& packet = std::get<Packet>(parsed);
  EXPECT_EQ(packet.sequence, 0x01020304U);
  EXPECT_EQ(packet.channel, "CAMERA");
  EXPECT_EQ(data_of(packet), "data");
  EXPECT_EQ(packet.message_size, 4U);
  EXPECT_EQ(packet.count, 1);
  EXPECT_TRUE(std::holds_alternative<Packet>(parse(whole_datagram("C", {}))));  // without data
}

TEST(Packet, FragmentsAreRead) {
  const auto first = parse(fragment_datagram({5, 10, 0, 0, 2}, bytes_of(std::string("CAMERA\0abcd", 11))));
  ASSERT_TRUE(std::holds_alternative<Packet>(first));
  EXPECT_EQ(std::get<Packet>(first).channel, "CAMERA");
  EXPECT_EQ(data_of(std::get<Packet>(first)), "abcd");
  const auto second = parse(fragment_datagram({5, 10, 4, 1, 2}, bytes_of("efghij")));
  ASSERT_TRUE(std::holds_alternative<Packet>(second));
  const Packet& packet = std::get<Packet>(second);
  EXPECT_EQ(packet.sequence, 5U);
  EXPECT_EQ(packet.channel, "");
  EXPECT_EQ(data_of(packet), "efghij");  // up to the very end
  EXPECT_EQ(packet.message_size, 10U);
  EXPECT_EQ(packet.offset, 4U);
  EXPECT_EQ(packet.number, 1);
  EXPECT_EQ(packet.count, 2);
}

TEST(Packet, HeadersThatEndTooSoonAreRefused) {
  const Bytes whole = whole_datagram("C", bytes_of("data"));
  for (std::size_t size = 0; size < 8; ++size)
    expect_refused({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}, Refusal::cut_short);
  const Bytes fragment = fragment_datagram({0, 10, 0, 1, 2}, bytes_of("data"));
  for (std::size_t size = 0; size < 20; ++size)
    expect_refused({fragment.begin(), fragment.begin() + static_cast<std::ptrdiff_t>(size)},
                   Refusal::cut_short);
}

TEST(Packet, OtherProtocolsAreRefused) {
  expect_refused(bytes_of("LC01LCM of old"), Refusal::unknown_magic);
  expect_refused(bytes_of("LC04????C"), Refusal::unknown_magic);
  expect_refused(bytes_of("M-SEARCH * HTTP/1.1"), Refusal::unknown_magic);
}

TEST(Packet, AChannelHasANameWithAnEnd) {
  const std::string longest(63, 'c');
  EXPECT_TRUE(std::holds_alternative<Packet>(parse(whole_datagram(longest, {}))));
  expect_refused(whole_datagram(longest + "c", {}), Refusal::bad_channel);
  expect_refused(whole_datagram("", bytes_of("data")), Refusal::bad_channel);
  expect_refused(bytes_of("LC02\1\1\1\1CAMERA"), Refusal::bad_channel);
  expect_refused(bytes_of("LC02\1\1\1\1"), Refusal::bad_channel);
  const FragmentHeader first{0, 10, 0, 0, 2};
  expect_refused(fragment_datagram(first, bytes_of("CAMERA")), Refusal::bad_channel);
  expect_refused(fragment_datagram(first, {}), Refusal::bad_channel);
  expect_refused(fragment_datagram(first, bytes_of(std::string("\0abcd", 5))), Refusal::bad_channel);
  expect_refused(fragment_datagram(first, bytes_of(longest + "c" + std::string("\0abcd", 5))),
                 Refusal::bad_channel);
}

TEST(Packet, SizesBeyondAllMessagesAreRefused) {
  const auto largest = static_cast<std::uint32_t>(largest_message);
  EXPECT_TRUE(
      std::holds_alternative<Packet>(parse(fragment_datagram({0, largest, 0, 1, 300}, bytes_of("x")))));
  for (const std::uint32_t size : {largest + 1, 1U << 28, 0x7fffffffU, 0x80000000U, 0xffffffffU})
    expect_refused(fragment_datagram({0, size, 0, 1, 300}, bytes_of("x")), Refusal::too_large);
}

TEST(Packet, FragmentsAreNumberedBelowTheirCount) {
  expect_refused(fragment_datagram({0, 10, 0, 0, 0}, bytes_of(std::string("C\0data", 6))),
                 Refusal::bad_number);
  expect_refused(fragment_datagram({0, 10, 0, 2, 2}, bytes_of("x")), Refusal::bad_number);
  expect_refused(fragment_datagram({0, 10, 0, 65535, 2}, bytes_of("x")), Refusal::bad_number);
  expect_refused(fragment_datagram({0, 10, 0, 1, 11}, bytes_of("x")),
                 Refusal::bad_number);  // more than bytes
  expect_refused(fragment_datagram({0, 0, 0, 1, 2}, bytes_of("x")), Refusal::bad_number);
}

TEST(Packet, DataStayWithinTheirMessage) {
  EXPECT_TRUE(std::holds_alternative<Packet>(parse(fragment_datagram({0, 10, 6, 1, 2}, bytes_of("abcd")))));
  expect_refused(fragment_datagram({0, 10, 7, 1, 2}, bytes_of("abcd")), Refusal::beyond_end);
  expect_refused(fragment_datagram({0, 10, 0, 1, 2}, bytes_of("more than ten")), Refusal::beyond_end);
  for (const std::uint32_t offset : {11U, 0x7fffffffU, 0xfffffff0U, 0xfffffffcU, 0xffffffffU})
    expect_refused(fragment_datagram({0, 10, offset, 1, 2}, bytes_of("abcd")), Refusal::beyond_end);
  expect_refused(fragment_datagram({0, 10, 0, 1, 2}, {}), Refusal::nothing_carried);
  expect_refused(fragment_datagram({0, 10, 0, 0, 2}, bytes_of(std::string("C\0", 2))),
                 Refusal::nothing_carried);
  expect_refused(lcmslam::testing::killing_datagrams("CAMERA")[1], Refusal::beyond_end);
}

}  // namespace
}  // namespace lcmslam::udpm
