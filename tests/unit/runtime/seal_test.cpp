// Seals: what has one passes once; anything else about a message that changes is noticed.

#include <lcmslam/runtime/seal.hpp>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <deque>
#include <fstream>

#include <lcmslam/command_t.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/log/seal_trailer.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/runtime/sealed_reader.hpp>
#include "tests/unit/log/sample_log.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

const WallTime now(std::chrono::seconds(1'800'000'000));

BusKey key_of(std::uint8_t byte) {
  BusKey key;
  key.fill(byte);
  return key;
}

BusMessage sealed(Sealer& sealer, const std::string& channel, std::vector<std::uint8_t> bytes,
                  WallTime at = now) {
  sealer.seal(channel, bytes, at);
  return {channel, bytes};
}

class Sealed : public ::testing::Test {
 protected:
  std::optional<Refusal> open(BusMessage message, WallTime at = now) { return checker_.open(message, at); }

  Sealer sealer_{key_of(1), 77};
  SealChecker checker_{key_of(1)};
};

TEST_F(Sealed, ComesOutAsItWentIn) {
  for (const std::vector<std::uint8_t>& bytes :
       {std::vector<std::uint8_t>{}, {1, 2, 3}, std::vector<std::uint8_t>(5000, 9)}) {
    BusMessage message = sealed(sealer_, "COMMAND", bytes);
    EXPECT_EQ(message.bytes.size(), bytes.size() + seal::trailer_size);
    EXPECT_EQ(checker_.open(message, now), std::nullopt);
    EXPECT_EQ(message.bytes, bytes);
  }
}

TEST_F(Sealed, EveryChangedBitIsNoticed) {
  const BusMessage message = sealed(sealer_, "COMMAND", {1, 2, 3, 4});
  for (std::size_t i = 0; i < 8 * message.bytes.size(); ++i) {
    BusMessage changed = message;
    changed.bytes[i / 8] ^= static_cast<std::uint8_t>(1U << (i % 8));
    EXPECT_EQ(open(changed), Refusal::unsealed) << "bit " << i;
  }
  BusMessage shorter = message, elsewhere = message;
  shorter.bytes.erase(shorter.bytes.begin());
  elsewhere.channel = "COMMANDO";
  EXPECT_EQ(open(shorter), Refusal::unsealed);
  EXPECT_EQ(open(elsewhere), Refusal::unsealed);
  EXPECT_EQ(open({"COMMAND", {1, 2, 3, 4}}), Refusal::unsealed);
  EXPECT_EQ(open(message), std::nullopt);
}

TEST_F(Sealed, WhoHasAnotherKeyIsAStranger) {
  Sealer other(key_of(2), 77);
  EXPECT_EQ(open(sealed(other, "COMMAND", {1})), Refusal::unsealed);
}

TEST_F(Sealed, NothingPassesTwiceOrLate) {
  const BusMessage first = sealed(sealer_, "COMMAND", {1}), second = sealed(sealer_, "COMMAND", {2});
  EXPECT_EQ(open(second), std::nullopt);
  EXPECT_EQ(open(second), Refusal::replayed);
  EXPECT_EQ(open(first), Refusal::replayed);
  EXPECT_EQ(open(sealed(sealer_, "STATUS", {1})), std::nullopt);  // each channel has its own order
  Sealer restarted(key_of(1), 78);
  EXPECT_EQ(open(sealed(restarted, "COMMAND", {1})), std::nullopt);
  const BusMessage recorded = sealed(sealer_, "COMMAND", {3});
  EXPECT_EQ(open(recorded, now + std::chrono::seconds(31)), Refusal::replayed);
  EXPECT_EQ(open(recorded, now - std::chrono::seconds(31)), Refusal::replayed);
  EXPECT_EQ(open(recorded, now + std::chrono::seconds(29)), std::nullopt);
}

TEST_F(Sealed, AClockThatStandsOrGoesBackKeepsTheOrder) {
  EXPECT_EQ(open(sealed(sealer_, "COMMAND", {1})), std::nullopt);
  EXPECT_EQ(open(sealed(sealer_, "COMMAND", {2}, now - std::chrono::seconds(5))), std::nullopt);
}

command_t stop_command() {
  command_t command{};
  command.name = "stop";
  return command;
}

TEST_F(Sealed, StockDecodersDoNotSeeIt) {
  const BusMessage message = sealed(sealer_, "COMMAND", encode_message(stop_command()));
  command_t read;
  EXPECT_GT(read.decode(message.bytes.data(), 0, static_cast<int>(message.bytes.size())), 0);
  EXPECT_EQ(read.name, "stop");
}

TEST_F(Sealed, LogsOfAKeyedBusAreReadAsOthers) {
  const testing::ScratchFile file;
  LogWriter writer(file.path());
  const BusMessage message = sealed(sealer_, "COMMAND", encode_message(stop_command()));
  writer.write(1, message.channel, message.bytes);
  writer.close();
  const auto event = LogReader(file.path()).next();
  ASSERT_TRUE(event);
  EXPECT_EQ(decode_message<command_t>(event->data.data(), event->data.size()).name, "stop");
}

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
  SealedReader reader(std::make_unique<Source>(std::deque<BusMessage>{sealed(sealer, "COMMAND", {1, 2})}),
                      std::nullopt);
  BusMessage message;
  ASSERT_TRUE(reader.read(message, std::chrono::seconds(1)));
  EXPECT_EQ(message.bytes, (std::vector<std::uint8_t>{1, 2}));
}

class BusKeyFile : public ::testing::Test {
 protected:
  BusKey read(const std::string& text, mode_t mode = 0600) {
    std::ofstream(file_.path()) << text;
    chmod(file_.path().c_str(), mode);
    return read_bus_key(file_.path());
  }
  std::string error_of(const std::string& text, mode_t mode = 0600) {
    try {
      read(text, mode);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }
  testing::ScratchFile file_;
};

TEST_F(BusKeyFile, HoldsSixtyFourDigits) {
  EXPECT_EQ(read(std::string(62, '0') + "fF\n")[31], 0xff);
}

TEST_F(BusKeyFile, IsRefusedWithWhatWouldBeRight) {
  EXPECT_THAT(error_of(std::string(63, '0')), HasSubstr("64 hexadecimal digits"));
  EXPECT_THAT(error_of(std::string(63, '0') + "g"), HasSubstr("64 hexadecimal digits"));
  EXPECT_THAT(error_of(std::string(66, '0')), HasSubstr("64 hexadecimal digits"));
  EXPECT_THAT(error_of(std::string(64, '0'), 0640), HasSubstr("chmod 600 " + file_.path()));
  EXPECT_THAT(error_of(""), HasSubstr("openssl rand -hex 32"));
  EXPECT_THROW(read_bus_key("/nowhere/key"), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
