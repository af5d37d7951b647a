#include "tools/log/log_summary.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/unit/tools/log_samples.hpp"

namespace lcmslam {
namespace {

using namespace testing;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(LogSummary, TellsChannelsTypesRatesAndSizes) {
  const ScratchFolder folder;
  const LogSummary s = summarise_log(sample_log(folder, 4));
  EXPECT_EQ(s.events, 4 + 200 + 40 + 8);
  ASSERT_EQ(s.sessions.size(), 1U);
  EXPECT_EQ(s.sessions[0].first, sample_start);
  EXPECT_EQ(s.sessions[0].last, sample_start + 199 * 20'000);
  EXPECT_EQ(s.channels.size(), 4U);
  const ChannelSummary& camera = s.channels.at("CAMERA");
  EXPECT_EQ(camera.count, 40);
  EXPECT_NEAR(camera.rate, 10, 1e-9);
  EXPECT_EQ(camera.largest_gap, 100'000);
  EXPECT_EQ(camera.bytes, 40 * camera.largest);
  EXPECT_EQ(camera.senders.known().at(77).lost, 0);
  EXPECT_NEAR(s.channels.at("ENCODERS").rate, 50, 1e-9);
  EXPECT_TRUE(s.channels.at("ODD name, \xC3\xA4").senders.known().empty());
  EXPECT_THAT(format_summary(s), AllOf(HasSubstr("images_t"), HasSubstr("encoders_t"),
                                       HasSubstr("11666f726569676e"), Not(HasSubstr("damaged"))));
}

TEST(LogSummary, CountsWhatSendersNumberedAndTheLogLacks) {
  const ScratchFolder folder;
  const std::string file = (folder.path() / "gaps.lcmlog").string();
  LogWriter log(file);
  const Utime now = sample_start;
  for (const int seq : {0, 1, 2, 5, 6, 9}) log.write(now, "ENCODERS", encoders_message(now, seq));
  for (const int seq : {40, 42}) log.write(now, "ENCODERS", encoders_message(now, seq, 78));
  for (const int seq : {0, 2}) log.write(now, "CAMERA", camera_message(now, seq));
  log.write(now, "SHORT", Bytes{1, 2, 3});
  log.close();
  const LogSummary s = summarise_log(file);
  EXPECT_EQ(s.channels.at("ENCODERS").senders.known().at(77).lost, 4);
  EXPECT_EQ(s.channels.at("ENCODERS").senders.known().at(78).lost, 1);
  EXPECT_EQ(s.channels.at("CAMERA").senders.known().at(77).lost, 1);
  EXPECT_EQ(s.channels.at("SHORT").untyped, 1);
  EXPECT_THAT(format_summary(s), HasSubstr("no type"));
}

TEST(LogSummary, ChannelNamesDoNothingToATerminal) {
  const ScratchFolder folder;
  const std::string file = (folder.path() / "odd.lcmlog").string();
  LogWriter log(file);
  log.write(sample_start, "\x1b[31mRED", Bytes(9));
  log.write(sample_start, "\xff", Bytes(9));
  log.close();
  EXPECT_THAT(format_summary(summarise_log(file)),
              AllOf(HasSubstr("\\x1b[31mRED"), HasSubstr("\\xff"), Not(HasSubstr("\x1b"))));
}

TEST(LogSummary, ALogRecordedOfAReplayedLogHasNoDisorder) {
  const ScratchFolder folder;
  const std::string file = (folder.path() / "replays.lcmlog").string();
  LogWriter log(file);
  for (int i = 0; i < 60; ++i) {
    const Utime utime = sample_start + (i % 20) * 100'000;
    log.write(sample_start + i * 100'000, "ENCODERS", encoders_message(utime, i % 20));
  }
  log.close();
  const InputCount count = summarise_log(file).channels.at("ENCODERS").senders.known().at(77);
  EXPECT_EQ(count.lost + count.reordered + count.duplicates, 0);
}

TEST(LogSummary, SeveralSessionsAreToldApart) {
  const ScratchFolder folder;
  const std::string a = sample_log(folder, 2, "a"), b = sample_log(folder, 3, "b");
  folder.write("both", folder.read("a") + folder.read("b"));  // numbers and times begin anew
  const LogSummary s = summarise_log((folder.path() / "both").string());
  ASSERT_EQ(s.sessions.size(), 2U);
  EXPECT_EQ(s.sessions[1].offset, std::filesystem::file_size(a));
  EXPECT_EQ(s.sessions[0].events + s.sessions[1].events, s.events);
  EXPECT_EQ(s.jumps_back, 0);
  EXPECT_NEAR(s.channels.at("ENCODERS").rate, 50, 1e-9);  // the jump between is no interval
  EXPECT_THAT(format_summary(s), HasSubstr("2 sessions"));
}

TEST(LogSummary, SmallJumpsBackAreDisorder) {
  const ScratchFolder folder;
  const std::string file = (folder.path() / "x.lcmlog").string();
  LogWriter log(file);
  for (const Utime time : {1'000'000, 1'200'000, 1'100'000, 1'300'000}) log.write(time, "X", Bytes(9));
  log.close();
  const LogSummary s = summarise_log(file);
  EXPECT_EQ(s.sessions.size(), 1U);
  EXPECT_EQ(s.jumps_back, 1);
  EXPECT_EQ(s.largest_jump_back, 100'000);
  EXPECT_EQ(s.channels.at("X").jumps_back, 1);
  EXPECT_EQ(s.channels.at("X").largest_gap, 200'000);
}

TEST(LogSummary, MessagesInPiecesAreCountedAsSuch) {
  const ScratchFolder folder;
  const std::string file = (folder.path() / "pieces.lcmlog").string();
  LogWriter log(file);
  for (int i = 0; i < 5; ++i)
    write_pieces(log, sample_start + i, "CAMERA", camera_message(sample_start + i, i), i, i == 2 ? 1 : -1);
  log.close();
  const LogSummary s = summarise_log(file);
  EXPECT_EQ(s.in_pieces.at("CAMERA").whole, 4);
  EXPECT_EQ(s.in_pieces.at("CAMERA").incomplete, 1);
  EXPECT_EQ(s.in_pieces.at("CAMERA").pieces, s.channels.at("CAMERA_PART").count);
  EXPECT_THAT(format_summary(s), HasSubstr("CAMERA: 4 whole messages in"));
}

TEST(LogSummary, JsonHoldsTheSame) {
  const ScratchFolder folder;
  const std::string file = sample_log(folder, 2);
  { std::ofstream(file, std::ios::app | std::ios::binary) << "rubbish"; }
  const auto json = nlohmann::json::parse(summary_json(summarise_log(file)));
  EXPECT_EQ(json["events"], 2 + 100 + 20 + 4);
  EXPECT_EQ(json["channels"].size(), 4U);
  EXPECT_EQ(json["channels"][0]["channel"], "CAMERA");
  EXPECT_EQ(json["channels"][0]["types"][0]["name"], "images_t");
  EXPECT_TRUE(json["channels"][3]["types"][0]["name"].is_null());
  EXPECT_EQ(json["damages"].size(), 1U);
  EXPECT_EQ(json["sessions"][0]["first_utime"], sample_start);
}

}  // namespace
}  // namespace lcmslam
