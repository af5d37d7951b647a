// spy and echo tell the truth about what was sent.

#include <gmock/gmock.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include <lcmslam/messages/parts.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/status_t.hpp>
#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"

namespace lcmslam::integration {
namespace {

using Json = nlohmann::json;

class Spying : public testing::Test {
 protected:
  /// Starts a command and waits until it hears the bus.
  void start(const std::vector<std::string>& command) {
    program_.emplace(command);
    ASSERT_TRUE(wait_until([&] { return program_->wrote("listens to ") || !program_->running(); }, 30));
    ASSERT_TRUE(program_->running()) << program_->output();
  }

  static pose_estimate_t pose(std::int64_t seq) {
    pose_estimate_t message{};
    message.utime = 1'000'000 + 100'000 * seq;
    message.seq = seq;
    message.sender = 77;
    message.frame = "map";
    return message;
  }

  /// What came after the line that says where it listens.
  std::vector<std::string> answer() const {
    std::istringstream output(program_->output());
    std::vector<std::string> lines;
    for (std::string line; std::getline(output, line);)
      if (line.rfind("listens to ", 0) != 0) lines.push_back(line);
    return lines;
  }

  /// Ends spy by Ctrl-C; its table, by channel.
  std::map<std::string, Json> table() {
    bus_.wait_until_taken();
    program_->send(SIGINT);
    EXPECT_EQ(program_->wait(30).exit_code, 0) << program_->output();
    const auto lines = answer();
    std::map<std::string, Json> channels;
    if (lines.empty() || !Json::accept(lines.back())) {
      ADD_FAILURE() << program_->output();
      return channels;
    }
    const Json table = Json::parse(lines.back());
    EXPECT_EQ(table["kernel_drops"], 0);
    for (const Json& channel : table["channels"]) channels[channel["channel"]] = channel;
    return channels;
  }

  Bus bus_;
  std::optional<Program> program_;
};

TEST_F(Spying, TableHoldsChannelsCountsGapsAndErrors) {
  start({"lcmslam", "spy", "--once", "--json", "--seconds", "600"});
  const std::set<std::int64_t> skipped = {3, 4, 11};
  for (std::int64_t seq = 0; seq < 20; ++seq)
    if (skipped.count(seq) == 0) bus_.publish("ICP_POSE", pose(seq));
  bus_.publish("STATUS", status_t{});
  Bytes broken = encode_message(status_t{});
  broken.pop_back();
  bus_.publish("STATUS", broken);
  bus_.publish("LIDAR", Bytes{0x89, 0xdc, 0x5b, 0x87, 0x9a, 0x50, 0x56, 0xcf, 1});

  auto channels = table();
  EXPECT_EQ(channels.size(), 3U);
  EXPECT_EQ(channels["ICP_POSE"]["type"], "pose_estimate_t");
  EXPECT_EQ(channels["ICP_POSE"]["count"], 17);
  EXPECT_EQ(channels["ICP_POSE"]["gaps"], 3);
  EXPECT_EQ(channels["ICP_POSE"]["largest"], encode_message(pose(0)).size());
  EXPECT_EQ(channels["STATUS"]["count"], 2);
  EXPECT_EQ(channels["STATUS"]["decode_errors"], 1);
  EXPECT_EQ(channels["LIDAR"]["type"], "?? 89dc5b879a5056cf");
}

TEST_F(Spying, MessagesInPiecesAreShownWhole) {
  start({"lcmslam", "spy", "--once", "--json", "--seconds", "600"});
  pose_estimate_t big = pose(5);
  big.detail = std::string(100'000, 'x');
  const Bytes whole = encode_message(big);
  for (const part_t& part : split_message("ICP_POSE", whole, big.utime, 0, 20'000))
    bus_.publish("ICP_POSE_PART", part);
  auto channels = table();
  EXPECT_EQ(channels.size(), 1U);
  EXPECT_EQ(channels["ICP_POSE"]["count"], 1);
  EXPECT_EQ(channels["ICP_POSE"]["largest"], whole.size());
  EXPECT_EQ(channels["ICP_POSE"]["in_parts"], true);
  EXPECT_EQ(channels["ICP_POSE"]["lost_pieces"], 0);
}

TEST_F(Spying, EndsWhenTheReaderOfItsPipeGoesAway) {
  const Result result = run({"/bin/sh", "-c", find_program("lcmslam") + " spy --json | head -n 1"}, 30);
  EXPECT_EQ(result.exit_code, 0) << result.output;
}

TEST_F(Spying, SilenceIsNamed) {
  const Result result = run({"lcmslam", "spy", "--once", "--seconds", "0.2"}, 30);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.output, testing::HasSubstr("nothing was heard"));
}

TEST_F(Spying, AnUnusableBusIsNamed) {
  const Result result = run({"lcmslam", "spy", "--lcm-url", "pigeon://loft"}, 30);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, testing::HasSubstr("pigeon://loft: is no bus"));
}

TEST_F(Spying, EchoPrintsSoManyMessagesOfTheChannel) {
  start({"lcmslam", "echo", "ICP_.*", "--count", "3", "--json"});
  bus_.publish("STATUS", status_t{});
  for (const std::int64_t seq : {4, 8, 15, 16}) bus_.publish("ICP_POSE", pose(seq));
  EXPECT_EQ(program_->wait(30).exit_code, 0);
  const auto lines = answer();
  ASSERT_EQ(lines.size(), 3U) << program_->output();
  const std::vector<int> expected = {4, 8, 15};
  for (std::size_t i = 0; i < 3; ++i) {
    const Json json = Json::parse(lines[i]);
    EXPECT_EQ(json["channel"], "ICP_POSE");
    EXPECT_EQ(json["fields"]["seq"], expected[i]);
    EXPECT_EQ(json["fields"]["frame"], "map");
  }
}

TEST_F(Spying, EchoOfASilentChannelGivesUpInTime) {
  const Result result = run({"lcmslam", "echo", "NOBODY", "--count", "1", "--seconds", "0.2"}, 30);
  EXPECT_EQ(result.exit_code, 1) << result.output;
}

TEST_F(Spying, APatternThatIsNoneIsNamed) {
  const Result result = run({"lcmslam", "echo", "["}, 30);
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, testing::HasSubstr("no regular expression"));
}

TEST_F(Spying, LcmSpySaysWhatItLacks) {
  unsetenv("DISPLAY");
  const Result result = run({"lcmslam", "lcm-spy"}, 30);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, testing::AnyOf(testing::HasSubstr("apt-get install"),
                                            testing::HasSubstr("DISPLAY is not set")));
}

TEST_F(Spying, LcmSpyPrintsItsCommandWithoutADisplay) {
  unsetenv("DISPLAY");
  const Result result = run({"lcmslam", "lcm-spy", "--print"}, 30);
  const bool printed = result.exit_code == 0;
  EXPECT_THAT(result.output, testing::HasSubstr(printed ? "'lcm.spy.Spy'" : "apt-get install"));
}

}  // namespace
}  // namespace lcmslam::integration
