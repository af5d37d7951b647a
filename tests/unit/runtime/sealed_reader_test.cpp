#include <lcmslam/runtime/sealed_reader.hpp>

#include <gtest/gtest.h>

#include <deque>

#include "tests/unit/runtime/sealed_messages.hpp"

namespace lcmslam {
namespace {

/// Hands out what is in it.
class Source : public BusReader {
 public:
  explicit Source(std::deque<BusMessage> messages) : messages_(std::move(messages)) {}
  bool read(BusMessage& message, std::chrono::milliseconds) override {
    if (messages_.empty()) return false;
    message = messages_.front();
    messages_.pop_front();
    return true;
  }

 private:
  std::deque<BusMessage> messages_;
};

TEST(SealedReaderTest, WithAKeyOnlySealedMessagesPassAndTheOthersAreCounted) {
  Sealer sealer(key_of(1), 77), other(key_of(2), 78);
  const WallTime today = std::chrono::system_clock::now();
  const BusMessage good = sealed(sealer, "COMMAND", {1}, today);
  SealedReader reader(std::make_unique<Source>(std::deque<BusMessage>{
                          {"STATUS", {1}}, sealed(other, "COMMAND", {2}, today), good, good}),
                      key_of(1));
  BusMessage message;
  ASSERT_TRUE(reader.read(message, std::chrono::seconds(1)));
  EXPECT_EQ(message.bytes, std::vector<std::uint8_t>{1});
  EXPECT_FALSE(reader.read(message, std::chrono::seconds(1)));
  const Refusals refusals = reader.refusals();
  EXPECT_EQ(refusals.of(Refusal::unsealed), 2);
  EXPECT_EQ(refusals.of(Refusal::replayed), 1);
  EXPECT_EQ(refusals.malformed(), 0);
  EXPECT_EQ(refusals.text(), "3 messages not sealed by this bus's key (last on COMMAND)");
}

TEST(SealedReaderTest, WithoutAKeySealsComeOff) {
  Sealer sealer(key_of(1), 77);
  SealedReader reader(std::make_unique<Source>(std::deque<BusMessage>{
                          sealed(sealer, "COMMAND", {1, 2}, std::chrono::system_clock::now())}),
                      std::nullopt);
  BusMessage message;
  ASSERT_TRUE(reader.read(message, std::chrono::seconds(1)));
  EXPECT_EQ(message.bytes, (std::vector<std::uint8_t>{1, 2}));
}

}  // namespace
}  // namespace lcmslam
