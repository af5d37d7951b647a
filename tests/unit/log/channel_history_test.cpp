// What a channel's messages have in common.

#include <gtest/gtest.h>

#include <lcmslam/log/channel_history.hpp>
#include "tests/unit/log/sample_log.hpp"

namespace lcmslam {
namespace {

/// A message of a type (its first eight bytes) and a size.
testing::Bytes message(std::uint8_t type, std::size_t size) {
  testing::Bytes bytes(size, 7);
  std::fill_n(bytes.begin(), 8, type);
  return bytes;
}

class ChannelHistoryTest : public ::testing::Test {
 protected:
  void add(const testing::Bytes& bytes) { history_.add({0, 0, "CAMERA", bytes.data(), bytes.size(), 0}); }
  bool resembles(const testing::Bytes& bytes, const char* channel = "CAMERA") const {
    return history_.resembles(channel, bytes.data(), bytes.size());
  }
  ChannelHistory history_;
};

TEST_F(ChannelHistoryTest, ChannelsKeepTheirType) {
  EXPECT_FALSE(resembles(message(1, 20)));
  add(message(1, 20));
  EXPECT_TRUE(resembles(message(1, 20)));
  EXPECT_TRUE(resembles(message(1, 30)));
  EXPECT_FALSE(resembles(message(2, 20)));
  EXPECT_FALSE(resembles(message(1, 20), "DEPTH"));
}

TEST_F(ChannelHistoryTest, ThreeMessagesOfOneSizeMakeARule) {
  add(message(1, 20));
  add(message(1, 20));
  EXPECT_TRUE(resembles(message(1, 30)));
  add(message(1, 20));
  EXPECT_FALSE(resembles(message(1, 30)));
  EXPECT_TRUE(resembles(message(1, 20)));
  add(message(1, 24));  // it was none
  EXPECT_TRUE(resembles(message(1, 30)));
}

}  // namespace
}  // namespace lcmslam
