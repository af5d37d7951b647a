#include <lcmslam/runtime/sealed_reader.hpp>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <deque>
#include <fstream>

#include <lcmslam/encoders_t.hpp>
#include <lcmslam/runtime/status_reporter.hpp>
#include "tests/unit/log/sample_log.hpp"
#include "tests/unit/runtime/capturing_publisher.hpp"
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
  EXPECT_EQ(refusals.text(),
            "2 messages not sealed by this bus's key, 1 sealed messages that came again (last on COMMAND)");
}

/// Of the key that is all zeros.
std::vector<std::uint8_t> sealed_ago(std::chrono::seconds age) {
  Sealer sealer(key_of(0), 77);
  encoders_t message{};
  return sealed(sealer, "HOST_CLOCK", encode_message(message), std::chrono::system_clock::now() - age).bytes;
}

TEST(SealedReaderTest, ClocksThatDifferAreNotTakenForAWrongKey) {
  SealedReader reader(
      std::make_unique<Source>(std::deque<BusMessage>{{"HOST_CLOCK", sealed_ago(std::chrono::seconds(40))}}),
      key_of(0));
  BusMessage message;
  EXPECT_FALSE(reader.read(message, std::chrono::seconds(1)));
  const Refusals refusals = reader.refusals();
  EXPECT_EQ(refusals.of(Refusal::other_time), 1);
  EXPECT_EQ(refusals.malformed(), 0);
  EXPECT_THAT(refusals.text(), ::testing::StartsWith("1 messages sealed by the right key, but 40."));
  EXPECT_THAT(refusals.text(), ::testing::HasSubstr("one time server (last on HOST_CLOCK)"));
}

TEST(SealedReaderTest, StatusTellsByHowMuchTheClocksDiffer) {
  const testing::ScratchFile key;
  std::ofstream(key.path()) << std::string(64, '0');
  chmod(key.path().c_str(), 0600);
  setenv("LCMSLAM_BUS_KEY", key.path().c_str(), 1);
  LcmBus bus("memq://");
  Inputs inputs;
  inputs.subscribe<encoders_t>("HOST_CLOCK", 10, [](const encoders_t&) {});
  Receiver receiver(bus, inputs);
  unsetenv("LCMSLAM_BUS_KEY");
  testing::CapturingPublisher publisher;
  StatusReporter reporter("icp", publisher);
  const auto told = [&] {
    std::map<std::string, double> values;
    for (const value_t& value : reporter.gather({}, inputs, receiver).values)
      values[value.name] = value.value;
    return values;
  };
  EXPECT_EQ(told().count("bus_other_time"), 0U);
  const auto bytes = sealed_ago(std::chrono::seconds(-40));
  bus.lcm().publish("HOST_CLOCK", bytes.data(), static_cast<unsigned>(bytes.size()));
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (receiver.refused() == 0 && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  EXPECT_EQ(told()["bus_unsealed"], 1);
  EXPECT_EQ(told()["bus_other_time"], 1);
  EXPECT_NEAR(told()["bus_other_time_age"], -35, 5);  // above -30 it would not have been refused
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
