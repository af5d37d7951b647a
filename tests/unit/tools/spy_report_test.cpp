#include "tools/spy/spy_report.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace lcmslam {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

SpyReport sample() {
  SpyReport report;
  report.lcm_url = "udpm://";
  report.seconds = 4;
  ChannelReport camera;
  camera.channel = "CAMERA";
  camera.type = "images_t";
  camera.count = 120;
  camera.rate = {29.97, 0.0012, 5e6};
  camera.largest = 164'321;
  camera.senders = 1;
  camera.lost = 3;
  camera.pieces = 360;
  camera.age = 0.02;
  ChannelReport odd;
  odd.channel = "ODD\x1b[2J";
  odd.type = "?? 0123456789abcdef";
  odd.count = 1;
  odd.decode_errors = 2;
  odd.last_error = "too short";
  report.channels = {camera, odd};
  report.socket.receive_buffer = 425'984;
  return report;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream in(line);
  return {std::istream_iterator<std::string>(in), {}};
}

TEST(SpyText, HasALineForEachChannel) {
  const auto lines = lines_of(spy_text(sample()));
  ASSERT_EQ(lines.size(), 6U);  // heading, rule, two channels, the bus, spy's own socket
  EXPECT_THAT(words_of(lines[2]), ElementsAre("CAMERA", "images_t", "120", "30.0", "1.2", "5000.0", "164.3",
                                              "3", "0.0", "0", "in", "parts"));
  EXPECT_THAT(words_of(lines[3]), ElementsAre("ODD\\x1b[2J", "??", "0123456789abcdef", "1", "-", "-", "-",
                                              "0.0", "-", "0.0", "2", "too", "short"));
  EXPECT_THAT(lines[5], HasSubstr("buffer 426 kB, 0 dropped by the kernel"));
}

TEST(SpyText, NobodyTakesItsOwnLossesForThoseOfTheBus) {
  SpyReport report = sample();
  EXPECT_THAT(spy_text(report), Not(HasSubstr("spy's own (")));
  report.socket.kernel_drops = 17;
  EXPECT_THAT(spy_text(report), HasSubstr("17 dropped by the kernel"));
  EXPECT_THAT(spy_text(report), HasSubstr("may be spy's own"));
  report.left_out = 5;
  EXPECT_THAT(spy_text(report), HasSubstr("5 messages on further channels"));
}

TEST(SpyText, ShowsWhatWasRefused) {
  SpyReport report = sample();
  EXPECT_THAT(spy_text(report), Not(HasSubstr("refused")));
  report.refusals.counts[static_cast<std::size_t>(Refusal::foreign)] = 3;
  report.refusals.counts[static_cast<std::size_t>(Refusal::not_group)] = 2;
  report.refusals.last_stranger = "10.0.0.7:4711";
  report.refusals.counts[static_cast<std::size_t>(Refusal::beyond_end)] = 7;
  report.refusals.last_malformed = "data beyond the end of their message";
  report.refusals.counts[static_cast<std::size_t>(Refusal::incomplete)] = 4;
  report.refusals.counts[static_cast<std::size_t>(Refusal::other_time)] = 6;
  report.refusals.last_age = 40;
  report.refusals.last_unsealed = "HOST_CLOCK";
  report.dropped = 8;
  EXPECT_THAT(
      spy_text(report),
      HasSubstr(
          "refused: 5 packets of strangers (last 10.0.0.7:4711), 6 messages sealed by the right key, but "
          "40.0 s ago by their sender's clock: a recording, or let both machines' clocks follow one time "
          "server (last on HOST_CLOCK), 7 malformed (data beyond the end of their message), 4 messages "
          "lacked fragments\n"));
  EXPECT_THAT(spy_text(report), HasSubstr("8 messages came too fast for spy"));
  const auto json = nlohmann::json::parse(spy_json(report));
  EXPECT_EQ(json["refused_foreign"], 5);
  EXPECT_EQ(json["refused_unsealed"], 6);
  EXPECT_EQ(json["refused_other_time"], 6);
  EXPECT_EQ(json["refused_malformed"], 7);
  EXPECT_EQ(json["incomplete"], 4);
  EXPECT_EQ(json["dropped"], 8);
}

TEST(SpyText, SaysWhenNothingWasHeard) {
  SpyReport report = sample();
  report.channels.clear();
  EXPECT_THAT(spy_text(report), HasSubstr("nothing was heard"));
}

TEST(SpyJson, HoldsWhatTheTableShows) {
  const std::string text = spy_json(sample());
  EXPECT_EQ(text.find('\n'), text.size() - 1) << "one line";
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json["receive_buffer"], 425'984);
  ASSERT_EQ(json["channels"].size(), 2U);
  const auto& camera = json["channels"][0];
  EXPECT_EQ(camera["channel"], "CAMERA");
  EXPECT_EQ(camera["gaps"], 3);
  EXPECT_EQ(camera["largest"], 164'321);
  EXPECT_EQ(camera["in_parts"], true);
  EXPECT_NEAR(camera["jitter_ms"], 1.2, 1e-9);
  EXPECT_EQ(json["channels"][1]["decode_errors"], 2);
}

TEST(SpyScreen, CutsLinesBetweenCharactersAndSaysWhatItHides) {
  EXPECT_EQ(fit_to_screen("a\nb\n", 24, 80), "a\nb\n");
  EXPECT_EQ(fit_to_screen("abcdef\n\xe2\x82\xac\xe2\x82\xac\xe2\x82\xac\n", 24, 2),
            "ab\n\xe2\x82\xac\xe2\x82\xac\n");
  EXPECT_EQ(fit_to_screen("1\n2\n3\n4\n5\n", 5, 80), "1\n2\n3\n... 2 more lines\n");
  EXPECT_EQ(fit_to_screen("1\n2\n3\n4\n", 5, 80), "1\n2\n3\n4\n");
}

}  // namespace
}  // namespace lcmslam
