// Where an event may begin: headers that no writer makes are none.

#include <gtest/gtest.h>

#include "tests/unit/log/sample_log.hpp"

namespace lcmslam {
namespace {

using testing::Bytes;

std::optional<log_format::Header> header_of(const std::string& channel) {
  Bytes bytes;
  testing::append_event(bytes, {3, 4, channel, {1, 2, 3}});
  return log_format::header_at({bytes.data(), bytes.size()}, 0);
}

TEST(LogFormat, HeaderSaysWhatWasWritten) {
  const auto header = header_of("CAMERA");
  ASSERT_TRUE(header);
  EXPECT_EQ(header->number, 3);
  EXPECT_EQ(header->timestamp, 4);
  EXPECT_EQ(header->channel_size, 6U);
  EXPECT_EQ(header->data_size, 3U);
}

TEST(LogFormat, ChannelsHaveOneToManyBytesAndNoNul) {
  EXPECT_TRUE(header_of("C"));
  EXPECT_TRUE(header_of(std::string(log_format::longest_channel, 'C')));
  EXPECT_FALSE(header_of(""));
  EXPECT_FALSE(header_of(std::string(log_format::longest_channel + 1, 'C')));
  EXPECT_FALSE(header_of(std::string("CAM\0ERA", 7)));
}

TEST(LogFormat, LengthsAreSignedAndBounded) {
  Bytes bytes;
  testing::append_event(bytes, {3, 4, "CAMERA", {1, 2, 3}});
  for (const std::size_t at : {20U, 24U})
    for (const int first : {0x7f, 0x80, 0xff}) {
      Bytes changed = bytes;
      changed[at] = static_cast<std::uint8_t>(first);
      EXPECT_FALSE(log_format::header_at({changed.data(), changed.size()}, 0));
    }
}

}  // namespace
}  // namespace lcmslam
