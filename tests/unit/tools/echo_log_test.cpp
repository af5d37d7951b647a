#include "tools/echo/echo_log.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include <lcmslam/command_t.hpp>
#include "tests/unit/tools/log_samples.hpp"

namespace lcmslam {
namespace {

using namespace testing;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;

class EchoLog : public ::testing::Test {
 protected:
  std::vector<std::string> echo(const EchoOptions& options = {}) {
    std::vector<std::string> texts;
    const std::int64_t count = echo_log(request_, options, [&](const std::string& text) {
      texts.push_back(text);
      return true;
    });
    EXPECT_EQ(count, static_cast<std::int64_t>(texts.size()));
    return texts;
  }

  ScratchFolder folder_;
  EchoLogRequest request_{sample_log(folder_, 3), "CAMERA_CALIBRATION", {}, 0, 0};
};

TEST_F(EchoLog, PrintsAChannelsMessagesInTheirOrder) {
  const auto texts = echo();
  ASSERT_THAT(texts, SizeIs(3));
  EXPECT_THAT(texts[1],
              AllOf(StartsWith("CAMERA_CALIBRATION  camera_calibration_t, "), HasSubstr("seq: 1\n")));
}

TEST_F(EchoLog, TakesAnExpressionOfChannels) {
  request_.channels = "CAMERA.*";
  EXPECT_THAT(echo(), SizeIs(3 + 30));
}

TEST_F(EchoLog, TakesAPartOfTheTime) {
  request_.from = LogTime{1.0};
  EXPECT_THAT(echo(), SizeIs(2));
  request_.seconds = 1;
  EXPECT_THAT(echo(), SizeIs(1));
  request_.from = LogTime{static_cast<double>(sample_start + 2'000'000)};
  EXPECT_THAT(echo().at(0), HasSubstr("seq: 2\n"));
}

TEST_F(EchoLog, EndsAfterTheCountAndWhenNobodyReads) {
  request_.count = 2;
  EXPECT_THAT(echo(), SizeIs(2));
  request_.count = 0;
  EXPECT_EQ(echo_log(request_, {}, [](const std::string&) { return false; }), 1);
}

TEST_F(EchoLog, NoMessageIsAnErrorThatNamesTheChannels) {
  request_.channels = "CAMERAS";
  EXPECT_THAT([&] { echo(); },
              ThrowsMessage<std::runtime_error>(AllOf(HasSubstr("no message of channel 'CAMERAS'"),
                                                      HasSubstr("CAMERA, CAMERA_CALIBRATION"))));
  request_.channels = "CAMERA";
  request_.from = LogTime{1000.0};
  EXPECT_THAT([&] { echo(); }, ThrowsMessage<std::runtime_error>(HasSubstr("in that time")));
}

TEST_F(EchoLog, MessagesInPiecesAreWhole) {
  request_.file = (folder_.path() / "pieces.lcmlog").string();
  LogWriter log(request_.file);
  write_pieces(log, sample_start, "CAMERA_CALIBRATION", calibration_message(sample_start, 4), 0);
  log.close();
  EXPECT_THAT(echo(), ElementsAre(StartsWith("CAMERA_CALIBRATION  camera_calibration_t, ")));
}

TEST_F(EchoLog, ForeignTypesAreReadByTheirDefinitions) {
  const auto beats =
      read_definitions({folder_.write("beat_t.lcm", "package theirs; struct beat_t { int8_t n; }").string()});
  request_.file = (folder_.path() / "beats.lcmlog").string();
  request_.channels = "BEAT";
  Bytes beat(9, 5);
  for (std::size_t i = 0; i < 8; ++i)
    beat[i] = static_cast<std::uint8_t>(beats[0]->fingerprint >> (56 - 8 * i));
  LogWriter log(request_.file);
  log.write(sample_start, "BEAT", beat);
  log.close();
  EchoOptions options;
  options.types = KnownTypes(beats);
  EXPECT_THAT(echo(options), ElementsAre("BEAT  theirs.beat_t, 9 bytes\n  n: 5\n"));
}

class EchoCsv : public EchoLog {
 protected:
  EchoCsv() { options_.csv = true; }
  EchoOptions options_;
};

TEST_F(EchoCsv, IsARowOfNamesAndOneAMessage) {
  const auto rows = echo(options_);
  ASSERT_THAT(rows, SizeIs(3));
  const auto columns = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
  const std::string names = rows[0].substr(0, rows[0].find('\n'));
  EXPECT_THAT(names, StartsWith("channel,utime,seq,sender,sensor,colour.width,"));
  EXPECT_THAT(names, HasSubstr("T_colour_depth."));
  EXPECT_EQ(columns(names), columns(rows[1]));
  EXPECT_THAT(rows[1], StartsWith("CAMERA_CALIBRATION,1001000000,1,77,"));
  EXPECT_EQ(rows[1].find('\n'), rows[1].size() - 1);
}

TEST_F(EchoCsv, ArraysWhoseSizeVariesAreLeftOut) {
  command_t command{};
  CsvTable table;
  std::vector<std::string> rows;
  for (const char* key : {"icp", "fastslam"}) {
    command.keys.emplace_back(key);
    command.values.emplace_back("1");
    command.n = static_cast<std::int32_t>(command.keys.size());
    const Bytes bytes = encode_message(command);
    rows.push_back(table.row("COMMAND", MessageType::find(static_cast<std::uint64_t>(command_t::getHash())),
                             bytes.data(), bytes.size()));
  }
  EXPECT_THAT(rows[0], AllOf(StartsWith("channel,utime,"), ::testing::Not(HasSubstr("keys"))));
  EXPECT_EQ(std::count(rows[0].begin(), rows[0].end(), ','),
            2 * std::count(rows[1].begin(), rows[1].end(), ','))
      << "names and cells";
}

TEST_F(EchoCsv, NumbersAreExactAndTextsQuoted) {
  pose_estimate_t pose{};
  pose.utime = 123'456'789'012'345;
  pose.frame = "say \"map\", please";
  pose.T_map_robot.trans[0] = 0.1 + 0.2;
  pose.quality = 0.1F;
  pose.covariance[35] = std::numeric_limits<double>::quiet_NaN();
  const Bytes bytes = encode_message(pose);
  CsvTable table;
  const std::string text =
      table.row("POSE", MessageType::find(static_cast<std::uint64_t>(pose_estimate_t::getHash())),
                bytes.data(), bytes.size());
  EXPECT_THAT(text, HasSubstr("covariance[35]"));
  EXPECT_THAT(text, AllOf(HasSubstr("\nPOSE,123456789012345,"), HasSubstr(",\"say \"\"map\"\", please\","),
                          HasSubstr(",0.30000000000000004,"), HasSubstr(",0.1,"), HasSubstr(",nan,")));
}

TEST_F(EchoCsv, HasRowsOfOneKnownType) {
  request_.channels = "CAMERA_CALIBRATION|ENCODERS";
  EXPECT_THAT([&] { echo(options_); }, ThrowsMessage<std::runtime_error>(HasSubstr("rows of one type")));
  request_.channels = "ODD.*";
  EXPECT_THAT([&] { echo(options_); }, ThrowsMessage<std::runtime_error>(HasSubstr("--definitions")));
}

}  // namespace
}  // namespace lcmslam
