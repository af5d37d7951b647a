#include "tools/log/log_edit.hpp"

#include <gmock/gmock.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/part_t.hpp>
#include "tests/unit/tools/log_samples.hpp"
#include "tools/log/log_check.hpp"

namespace lcmslam {
namespace {

using namespace testing;
using ::testing::HasSubstr;

class LogEditTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  template <class Action>
  static std::string error_of(Action action) {
    try {
      action();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }
  static LogSelection between(double from, double to) {
    LogSelection selection;
    selection.from = LogTime{from};
    selection.to = LogTime{to};
    return selection;
  }
  ScratchFolder folder_;
};

TEST_F(LogEditTest, RepairKeepsEveryWholeEventAndTellsWhatIsLost) {
  const std::string file = sample_log(folder_, 20);
  const auto events = read_log(file);
  std::vector<std::uint64_t> offsets;
  LogReader reader(file);
  while (const auto event = reader.next_view()) offsets.push_back(event->offset);
  Random random(1);
  std::set<std::size_t> hit;
  for (int i = 0; i < 12; ++i) {
    hit.insert(5 + random.below(events.size() - 10));
    damage(file, offsets[*hit.rbegin()] + 1);  // sync words
  }
  for (const std::size_t i : hit) damage(file, offsets[i], 0x40);
  const LogEdit edit = repair_log(file, {path("b.lcmlog"), false});
  const auto repaired = read_log(path("b.lcmlog"));
  std::vector<const LogEvent*> expected;
  for (std::size_t i = 0; i < events.size(); ++i)
    if (hit.count(i) == 0) expected.push_back(&events[i]);
  ASSERT_EQ(repaired.size(), expected.size());
  for (std::size_t i = 0; i < repaired.size(); ++i) {
    EXPECT_EQ(repaired[i].timestamp, expected[i]->timestamp);
    EXPECT_EQ(repaired[i].channel, expected[i]->channel);
    EXPECT_EQ(repaired[i].data, expected[i]->data);
  }
  std::int64_t lost = 0;
  for (const auto& damage : edit.damages) lost += damage.lost;
  EXPECT_EQ(lost, static_cast<std::int64_t>(hit.size()));
  EXPECT_EQ(edit.written, static_cast<std::int64_t>(expected.size()));
  EXPECT_TRUE(check_log(path("b.lcmlog")).findings.empty());
}

TEST_F(LogEditTest, RepairOverwritesNothing) {
  const std::string file = sample_log(folder_, 1);
  EXPECT_THAT(error_of([&] { repair_log(file, {file, true}); }), HasSubstr("is the input"));
  std::filesystem::create_hard_link(file, path("link"));
  EXPECT_THAT(error_of([&] { repair_log(file, {path("link"), true}); }), HasSubstr("is the input"));
  folder_.write("other", "precious");
  EXPECT_THAT(error_of([&] { repair_log(file, {path("other"), false}); }), HasSubstr("--force"));
  EXPECT_EQ(folder_.read("other"), "precious");
  repair_log(file, {path("other"), true});
  EXPECT_EQ(read_log(path("other")).size(), read_log(file).size());
}

TEST_F(LogEditTest, NothingWholeIsAnErrorAndLeavesNoFile) {
  const std::string header("\xED\xA1\xDA\x01 but nothing that follows", 20);
  const std::string file = folder_.write("bad", header).string();
  EXPECT_THAT(error_of([&] {
                repair_log(file, {path("out"), false});
              }),
              HasSubstr("no event in it is whole"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1);
}

TEST_F(LogEditTest, CutTakesTimesFromTheLogsStartAndPutsTheCalibrationFirst) {
  const std::string file = sample_log(folder_, 10);
  cut_log(file, {path("b"), false}, between(2.5, 4.5));
  const auto events = read_log(path("b"));
  EXPECT_EQ(count(events, "ENCODERS"), 100U);
  EXPECT_EQ(count(events, "CAMERA"), 20U);
  ASSERT_EQ(count(events, "CAMERA_CALIBRATION"), 3U);  // that of 2 s, 3 s and 4 s
  EXPECT_EQ(events[0].channel, "CAMERA_CALIBRATION");
  EXPECT_EQ(events[0].timestamp, sample_start + 2'500'000);
  EXPECT_EQ(events[0].data, calibration_message(sample_start + 2'000'000, 2));
  EXPECT_EQ(events[1].timestamp, sample_start + 2'500'000);
  EXPECT_LT(events.back().timestamp, sample_start + 4'500'000);
}

TEST_F(LogEditTest, TwoCutsMakeTheWhole) {
  const std::string file = sample_log(folder_, 6);
  LogSelection first, second;
  first.to = LogTime{2.98};
  second.from = LogTime{2.98};
  cut_log(file, {path("b"), false}, first);
  cut_log(file, {path("c"), false}, second);
  auto all = read_log(path("b"));
  const auto rest = read_log(path("c"));
  all.insert(all.end(), rest.begin() + 1, rest.end());  // without the calibration put at the head
  const auto whole = read_log(file);
  ASSERT_EQ(all.size(), whole.size());
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].data, whole[i].data);
}

TEST_F(LogEditTest, CutTakesUtimesAndChannels) {
  const std::string file = (folder_.path() / "late").string();
  LogWriter log(file);
  write_sample(log, 5, 1'700'000'000'000'000);
  log.close();
  LogSelection selection = between(1'700'000'001'000'000, 1'700'000'002'000'000);
  selection.channels = {"ENCODERS", "ODD name, \xC3\xA4"};
  cut_log(file, {path("b"), false}, selection);
  const auto events = read_log(path("b"));
  EXPECT_EQ(count(events, "ENCODERS"), 50U);
  EXPECT_EQ(count(events, "ODD name, \xC3\xA4"), 2U);
  EXPECT_EQ(events.size(), 52U);
  LogSelection without;
  without.without_channels = {"CAMERA", "CAMERA_CALIBRATION"};
  cut_log(file, {path("c"), false}, without);
  EXPECT_EQ(read_log(path("c")).size(), 250U + 10U);
}

TEST_F(LogEditTest, CutOfNothingNamesWhatIsWrong) {
  const std::string file = sample_log(folder_, 2);
  const LogOutput output{path("b"), false};
  EXPECT_THAT(error_of([&] { cut_log(file, output, between(3, 2)); }), HasSubstr("--from 3 --to 2"));
  EXPECT_THAT(error_of([&] { cut_log(file, output, between(-1, 2)); }), HasSubstr("--from -1"));
  EXPECT_THAT(error_of([&] { cut_log(file, output, between(50, 60)); }), HasSubstr("no event lies within"));
  LogSelection selection;
  selection.channels = {"CAMRA"};
  EXPECT_THAT(error_of([&] { cut_log(file, output, selection); }),
              AllOf(HasSubstr("'CAMRA'"), HasSubstr("CAMERA, CAMERA_CALIBRATION, ENCODERS")));
  EXPECT_FALSE(std::filesystem::exists(path("b")));
  LogSelection without;
  without.without_channels = {"CAMARA"};
  EXPECT_THAT(error_of([&] {
                cut_log(file, {path("b.lcmlog"), false}, without);
              }),
              HasSubstr("no channel 'CAMARA'"));
}

/// Of the sample's images.
RgbdCalibration sample_calibration() {
  RgbdCalibration c;
  c.sensor = "new";
  c.colour = {300, 1, 250, 250, 150, 0, {}};
  c.depth = {150, 1, 125, 125, 75, 0, {}};
  return c;
}

TEST_F(LogEditTest, CalibratePutsTheFilesCalibrationInThePlaceOfTheLogs) {
  const std::string file = sample_log(folder_, 5);
  const LogEdit edit = calibrate_log(file, {path("b"), false}, sample_calibration());
  const auto events = read_log(path("b"));
  EXPECT_EQ(edit.written, static_cast<std::int64_t>(events.size()));
  EXPECT_EQ(count(events, "CAMERA_CALIBRATION"), 5U);
  EXPECT_EQ(count(events, "CAMERA"), 50U);
  EXPECT_EQ(count(events, "ENCODERS"), 250U);
  bool calibrated = false;
  std::int64_t seq = 0;
  for (const LogEvent& event : events) {
    EXPECT_TRUE(calibrated || event.channel != "CAMERA") << "images before the first calibration";
    if (event.channel != "CAMERA_CALIBRATION") continue;
    calibrated = true;
    const auto message = decode_message<camera_calibration_t>(event.data.data(), event.data.size());
    EXPECT_EQ(message.sensor, "new");
    EXPECT_EQ(message.colour.fx, 250);
    EXPECT_EQ(message.seq, seq++);
    EXPECT_EQ(message.utime, event.timestamp);
  }
  EXPECT_TRUE(check_log(path("b")).findings.empty());
}

TEST_F(LogEditTest, CalibrateRefusesACalibrationOfOtherImages) {
  const std::string file = sample_log(folder_, 2);
  const LogOutput output{path("b"), false};
  RgbdCalibration other = sample_calibration();
  other.colour.width = 640;
  EXPECT_THAT(error_of([&] { calibrate_log(file, output, other); }),
              AllOf(HasSubstr("no images fit"), HasSubstr("300x1"), HasSubstr("640x1")));
  LogSelection wheels;
  wheels.channels = {"ENCODERS"};
  cut_log(file, {path("wheels"), false}, wheels);
  EXPECT_THAT(error_of([&] { calibrate_log(path("wheels"), output, sample_calibration()); }),
              AllOf(HasSubstr("has no images"), HasSubstr("it has ENCODERS")));
  EXPECT_THAT(error_of([&] {
                calibrate_log(file, {file, true}, sample_calibration());
              }),
              HasSubstr("is the input"));
  EXPECT_FALSE(std::filesystem::exists(path("b")));
}

TEST_F(LogEditTest, MessagesInPiecesBecomeWhole) {
  const std::string file = path("pieces");
  LogWriter log(file);
  for (int i = 0; i < 5; ++i) {
    const Utime now = sample_start + 100'000 * i;
    write_pieces(log, now, "CAMERA", camera_message(now, i), i, i == 2 ? 1 : -1);
    log.write(now, "ENCODERS", encoders_message(now, i));
  }
  log.close();
  const LogEdit edit = repair_log(file, {path("b"), false});
  EXPECT_EQ(edit.joined, 4);
  EXPECT_EQ(edit.incomplete, 1);
  const auto events = read_log(path("b"));
  EXPECT_EQ(count(events, "CAMERA"), 4U);
  EXPECT_EQ(count(events, "CAMERA_PART"), 0U);
  EXPECT_EQ(count(events, "ENCODERS"), 5U);
  EXPECT_EQ(events[0].data, camera_message(sample_start, 0));
  LogSelection camera;
  camera.channels = {"CAMERA"};
  EXPECT_EQ(cut_log(file, {path("c"), false}, camera).written, 4);
}

TEST_F(LogEditTest, CutMakesAnOrdinaryLogOfOneRobot) {
  LogWriter writer(path("both.lcmlog"));
  for (int i = 0; i < 10; ++i)
    for (const std::string robot : {"dora", "ed"}) {
      part_t part{};
      part.utime = i;
      part.channel = robot + "/CAMERA";
      part.message = i;
      part.n_parts = 1;
      part.total_size = part.size = 1;
      part.data = {static_cast<std::uint8_t>(robot.size())};
      writer.write(i, robot + "/ODOMETRY", {1, 2, 3});
      writer.write(i, robot + "/CAMERA_PART", encode_message(part));
    }
  writer.close();
  EXPECT_EQ(cut_log(path("both.lcmlog"), {path("ed.lcmlog"), false}, {}, "ed").written, 20);
  for (const LogEvent& event : read_log(path("ed.lcmlog"))) {
    EXPECT_THAT(event.channel, ::testing::AnyOf("ODOMETRY", "CAMERA"));
    if (event.channel == "CAMERA") {
      EXPECT_EQ(event.data, std::vector<std::uint8_t>{2}) << "dora's";
    }
  }
  EXPECT_THAT(error_of([&] {
                cut_log(path("both.lcmlog"), {path("x.lcmlog"), false}, {}, "eddie");
              }),
              HasSubstr("no event"));
}

}  // namespace
}  // namespace lcmslam
