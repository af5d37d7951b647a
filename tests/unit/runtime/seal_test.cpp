// Seals: what has one passes once; anything else about a message that changes is noticed.

#include <lcmslam/runtime/seal.hpp>

#include <gtest/gtest.h>

#include <lcmslam/command_t.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/log/seal_trailer.hpp>
#include <lcmslam/messages/decode.hpp>
#include "tests/unit/log/sample_log.hpp"
#include "tests/unit/runtime/sealed_messages.hpp"

namespace lcmslam {
namespace {

const WallTime now(std::chrono::seconds(1'800'000'000));

class Sealed : public ::testing::Test {
 protected:
  static BusMessage sealed(Sealer& sealer, const std::string& channel, std::vector<std::uint8_t> bytes,
                           WallTime at = now) {
    return lcmslam::sealed(sealer, channel, std::move(bytes), at);
  }
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
  EXPECT_EQ(open(recorded, now + std::chrono::seconds(31)), Refusal::other_time);
  EXPECT_NEAR(checker_.last_age(), 31, 0.001);
  EXPECT_EQ(open(recorded, now - std::chrono::seconds(31)), Refusal::other_time);
  EXPECT_NEAR(checker_.last_age(), -31, 0.001);
  EXPECT_EQ(open(recorded, now + std::chrono::seconds(29)), std::nullopt);
}

TEST_F(Sealed, AClockThatStandsOrGoesBackKeepsTheOrder) {
  EXPECT_EQ(open(sealed(sealer_, "COMMAND", {1})), std::nullopt);
  EXPECT_EQ(open(sealed(sealer_, "COMMAND", {2}, now - std::chrono::seconds(5))), std::nullopt);
}

// Else nobody takes anything until the clock is where it was: stops neither.
TEST_F(Sealed, AClockThatIsSetBackFarSilencesNobody) {
  EXPECT_EQ(open(sealed(sealer_, "COMMAND", {1})), std::nullopt);
  for (const int hours : {1, 5}) {
    const auto earlier = now - std::chrono::hours(hours);
    const BusMessage message = sealed(sealer_, "COMMAND", {2}, earlier);
    EXPECT_EQ(open(message, earlier), std::nullopt) << hours;
    EXPECT_EQ(open(message, earlier), Refusal::replayed) << hours;
    EXPECT_EQ(open(sealed(sealer_, "COMMAND", {3}, earlier), earlier), std::nullopt) << hours;
  }
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

}  // namespace
}  // namespace lcmslam
