#include <lcmslam/runtime/sender_counts.hpp>

#include <gmock/gmock.h>

#include <algorithm>

#include <lcmslam/command_t.hpp>
#include <lcmslam/runtime/status_reporter.hpp>
#include "tests/unit/runtime/capturing_publisher.hpp"

namespace lcmslam {
namespace {

using ::testing::Contains;
using ::testing::Key;
using ::testing::Not;

/// A message from each of these.
void hear(SenderCounts& senders, std::int64_t first, std::int64_t last) {
  for (std::int64_t sender = first; sender <= last; ++sender) ++senders.of(sender).received;
}

TEST(SenderCounts, WhoWasNotHeardForLongestMakesRoomAndItsCountsStay) {
  SenderCounts senders;
  senders.of(1).follow(0);
  senders.of(1).follow(5);  // four are lost
  hear(senders, 1, 64);
  hear(senders, 2, 2);    // speaks all the while
  hear(senders, 65, 66);  // in the place of 1 and 3
  for (const std::int64_t sender : {2, 4, 65, 66}) EXPECT_THAT(senders.known(), Contains(Key(sender)));
  for (const std::int64_t sender : {1, 3}) EXPECT_THAT(senders.known(), Not(Contains(Key(sender))));
  EXPECT_EQ(senders.table().at(0).lost, 4);
  EXPECT_EQ(senders.table().at(0).received, 2);
  EXPECT_EQ(senders.total().received, 67);
  EXPECT_EQ(senders.total().lost, 4);
}

/// `lcmslam send` reads in STATUS whether it was heard: also the hundredth of its calls.
TEST(SenderCounts, StatusNamesANewSenderAfterAHundredOthers) {
  LcmBus bus("memq://");
  Inputs inputs;
  Input& input = inputs.subscribe<command_t>("COMMAND", 100, [](const command_t&) {});
  Receiver receiver(bus, inputs);
  testing::CapturingPublisher publisher;
  StatusReporter reporter("icp", publisher);
  command_t command{};
  for (command.sender = 1; command.sender <= 100; ++command.sender) {
    const auto bytes = encode_message(command);
    input.deliver(bytes.data(), bytes.size());
    const status_t status = reporter.gather({}, inputs, receiver);
    std::int64_t received = 0;
    int spoke = 0;
    for (const input_status_t& in : status.inputs) {
      received += in.received;
      spoke += in.rate > 0 ? 1 : 0;
    }
    EXPECT_TRUE(std::any_of(status.inputs.begin(), status.inputs.end(), [&](const auto& in) {
      return in.sender == command.sender && in.received == 1;
    })) << command.sender;
    EXPECT_EQ(received, command.sender);
    EXPECT_EQ(spoke, 1) << "since the last status";
  }
}

}  // namespace
}  // namespace lcmslam
