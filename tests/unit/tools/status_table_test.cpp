#include "tools/launch/status_table.hpp"

#include <gmock/gmock.h>

#include <sstream>

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

input_status_t input(const std::string& channel, std::int64_t received, std::int64_t lost, double rate) {
  input_status_t in{};
  in.channel = channel;
  in.received = received;
  in.lost = lost;
  in.queue_drops = 2;
  in.decode_errors = 1;
  in.rate = rate;
  return in;
}

status_t status() {
  status_t s{};
  s.process = "surf";
  s.pid = 42;
  s.state = status_t::RUNNING;
  s.cpu = 0.37;
  s.memory = 81'000'000;
  s.latency_p50 = 0.012;
  s.latency_p95 = 0.034;
  s.inputs = {input("CAMERA", 100, 5, 30), input("CAMERA", 10, 3, 0), input("ODOMETRY", 500, 0, 50)};
  output_status_t features{}, own{};
  features.channel = "FEATURES";
  features.rate = 29.6;
  own.channel = "STATUS";
  own.rate = 1;
  s.outputs = {features, own};
  value_t value;
  value.name = "keypoints";
  value.value = 480;
  s.values = {value};
  return s;
}

Supervisor::State process(const std::string& name, pid_t pid, const std::string& last_exit = "") {
  Supervisor::State state;
  state.spec.name = name;
  state.pid = pid;
  state.last_exit = last_exit;
  return state;
}

std::vector<std::string> lines(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> result;
  for (std::string line; std::getline(stream, line);) result.push_back(line);
  return result;
}

TEST(StatusTable, AnotherGraphsStatusIsLeftOut) {
  StatusBoard board;
  status_t other = status();
  other.pid = 43;
  take_status(board, status(), {process("surf", 42)});
  take_status(board, other, {process("surf", 42)});
  ASSERT_EQ(board.size(), 1U);
  EXPECT_EQ(board.at("surf").pid, 42);
}

TEST(StatusTable, ShowsAProcessWithItsLoadLossesAndRates) {
  const auto table = lines(format_status({{"surf", status()}}, {process("surf", 42)}));
  ASSERT_EQ(table.size(), 7U);  // heading, process, its rates, how good it is, its three inputs
  EXPECT_THAT(table[1], AllOf(HasSubstr("surf"), HasSubstr("42"), HasSubstr("running"), HasSubstr(" 37 "),
                              HasSubstr(" 81 "), HasSubstr("12/34")));
  EXPECT_EQ(table[2], "  Hz: CAMERA 30 ODOMETRY 50 -> FEATURES 30");
  EXPECT_EQ(table[3], "  480 features a frame");
  // lost, drops and malformed of all inputs stand under their headings
  for (const auto& [heading, value] :
       {std::pair("lost", "8"), std::pair("drops", "6"), std::pair("bad", "3")}) {
    const std::size_t end = table[0].find(heading) + std::string(heading).size();
    EXPECT_EQ(table[1].substr(end - 1, 1), value) << heading;
  }
}

TEST(StatusTable, SaysWhatAProcessWaitsFor) {
  status_t s = status();
  s.detail = "waits for CAMERA_CALIBRATION";
  s.inputs.clear();
  s.outputs.clear();
  const auto table = lines(format_status({{"surf", s}}, {process("surf", 42)}));
  EXPECT_THAT(table[1], AllOf(HasSubstr(" waits "), Not(HasSubstr("running"))));
  EXPECT_EQ(table[2], "  waits for CAMERA_CALIBRATION");
  s.state = status_t::FINISHED;
  EXPECT_THAT(lines(format_status({{"surf", s}}, {process("surf", 42)}))[1], HasSubstr("finished"));
}

TEST(StatusTable, SaysHowGoodAMapperIs) {
  status_t s = status();
  const auto set = [&](const char* name, double value) {
    s.values.emplace_back();
    s.values.back().name = name;
    s.values.back().value = value;
  };
  set("steps", 200);
  set("lost", 10);
  set("landmarks", 3500);
  set("matched", 120);
  EXPECT_THAT(format_status({{"surf", s}}, {process("surf", 42)}),
              HasSubstr("\n  95 % of 200 frames placed in the map, 480 features a frame, 3500 landmarks,\n"
                        "    120 of them seen\n"));
}

TEST(StatusTable, FitsATerminalOfEightyColumns) {
  status_t s = status();
  s.process = "map-server";
  s.memory = 1'234'000'000;
  s.detail =
      "a detail that goes on and on, because it names the file, the value and what would be right there";
  s.latency_p50 = 1.2;
  s.latency_p95 = 3.4;
  for (const char* channel :
       {"FASTSLAM_LANDMARKS", "ICP_KEYFRAME_PART", "FASTSLAM_ASSOCIATIONS", "ICP_GRAPH"}) {
    s.inputs.push_back(input(channel, 0, 0, 100));
    s.inputs.back().queue_drops = s.inputs.back().decode_errors = 0;
  }
  s.inputs.erase(s.inputs.begin(), s.inputs.begin() + 3);
  for (const std::string& line : lines(format_status({{"map-server", s}}, {process("map-server", 1234567)})))
    EXPECT_LE(line.size(), 80U) << line;
}

TEST(StatusTable, NamesEveryChannelAndSenderWithTrouble) {
  status_t s = status();
  input_status_t clean{}, odd{};
  clean.channel = "ICP_POSE";
  clean.received = 77;
  odd.channel = "FASTSLAM_POSE";
  odd.sender = 0xabcd;
  odd.received = 9;
  odd.duplicates = 1;
  odd.reordered = 2;
  odd.queue_age = 0.25;
  odd.last_error = "type not known";
  s.inputs = {clean, odd};
  const std::string table = format_status({{"surf", s}}, {process("surf", 42)});
  EXPECT_EQ(table.find("ICP_POSE of"), std::string::npos);
  EXPECT_THAT(table,
              HasSubstr("surf <- FASTSLAM_POSE of 0000abcd: 9 received, 0 lost, 1 twice, 2 out of order, "
                        "0 malformed, 0 skipped, 250 ms in the queue (type not known)\n"));
  EXPECT_EQ(lines(table)[1].substr(lines(table)[0].find("age ms") + 3, 3), "250");
}

TEST(StatusTable, ShowsProcessesThatHaveNotReportedOrHaveEnded) {
  const auto table = lines(
      format_status({{"surf", status()}}, {process("icp", 7), process("surf", 0, "signal 9 (Killed)")}));
  ASSERT_EQ(table.size(), 3U);  // nothing of the inputs of a process that has ended
  EXPECT_THAT(table[1], AllOf(HasSubstr("icp"), HasSubstr("starting")));
  EXPECT_THAT(table[2], AllOf(HasSubstr("surf"), HasSubstr("signal 9 (Killed)"), Not(HasSubstr("running"))));
}

TEST(StatusTable, ForeignStateNumbersDoNoHarm) {
  status_t s = status();
  for (const int state : {-1, 5, 127}) {
    s.state = static_cast<std::int8_t>(state);
    EXPECT_THAT(format_status({{"surf", s}}, {process("surf", 42)}), HasSubstr("?"));
  }
}

TEST(StatusTable, LossOfAChannelIsSummedOverItsSenders) {
  const ChannelLoss loss = channel_loss(status(), "CAMERA");
  EXPECT_EQ(loss.received, 110);
  EXPECT_EQ(loss.lost, 8);
  EXPECT_EQ(loss.queue_drops, 4);
  EXPECT_EQ(loss.decode_errors, 2);
  EXPECT_EQ(channel_loss(status(), "NONE").received, 0);
  EXPECT_EQ(status_value(status(), "keypoints"), 480);
  EXPECT_EQ(status_value(status(), "none"), 0);
}

TEST(StatusTable, SaysWhatCameFromTheNetworkAndWasRefused) {
  status_t s = status();
  EXPECT_THAT(format_status({{"surf", s}}, {process("surf", 42)}), Not(HasSubstr("<- bus")));
  for (const auto& [name, count] :
       {std::pair("bus_foreign", 5.0), std::pair("bus_malformed", 7.0), std::pair("bus_incomplete", 0.0)}) {
    value_t value;
    value.name = name;
    value.value = count;
    s.values.push_back(value);
  }
  EXPECT_THAT(format_status({{"surf", s}}, {process("surf", 42)}),
              HasSubstr("surf <- bus: 5 packets of strangers, 7 malformed, 0 messages lacked fragments\n"));
}

value_t value_of(const std::string& name, double value) {
  value_t v;
  v.name = name;
  v.value = value;
  return v;
}

TEST(StatusTable, TellsClocksThatDifferFromAWrongKey) {
  status_t s = status();
  s.values = {value_of("bus_unsealed", 17), value_of("bus_other_time", 17),
              value_of("bus_other_time_age", 40)};
  std::string table = format_status({{"surf", s}}, {process("surf", 42)});
  EXPECT_THAT(table, HasSubstr("surf <- bus: 17 messages sealed by the right key, but 40.0 s ago by their "
                               "sender's clock: "));
  EXPECT_THAT(table, Not(HasSubstr("not sealed by its key")));
  s.values = {value_of("bus_unsealed", 20), value_of("bus_other_time", 17),
              value_of("bus_other_time_age", -40)};
  table = format_status({{"surf", s}}, {process("surf", 42)});
  EXPECT_THAT(table, HasSubstr("surf <- bus: 3 messages that are not sealed by its key\n"));
  EXPECT_THAT(table, HasSubstr("but 40.0 s ahead of this machine's clock: "));
}

// Anybody can send a STATUS.
TEST(StatusTable, ControlCharactersDoNotReachTheTerminal) {
  status_t s = status();
  const std::string evil = "\x1b[31mEVIL";
  s.detail = evil;
  s.inputs[0].channel = evil;
  s.inputs[0].last_error = evil;
  s.outputs[0].channel = evil;
  const std::string table = format_status({{"surf", s}}, {process("surf", 42)});
  EXPECT_EQ(table.find('\x1b'), std::string::npos);
  EXPECT_THAT(table, HasSubstr("(\\x1b[31mEVIL)"));
}

}  // namespace
}  // namespace lcmslam
