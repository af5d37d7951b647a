// What goes out to other people's viewers comes back.

#include <gmock/gmock.h>

#include <lcmslam/ground_truth_t.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/pose_t.hpp>
#include <lcmslam/recordings/recording_file.hpp>
#include "tests/unit/tools/command_run.hpp"
#include "tests/unit/tools/log_samples.hpp"
#include "tools/commands.hpp"
#include "tools/log/mcap_export.hpp"
#include "tools/log/message_reader.hpp"

namespace lcmslam {
namespace {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::Pair;

constexpr Utime frame_interval = 33'333;

class ExportedLog : public ::testing::Test {
 protected:
  /// Depth's clock is off by `offset`; each colour image has a depth image of 4 ms later, as the calibration
  /// says. The first frames come before the calibration.
  void write_drive(double offset) {
    RgbdCalibration c;
    c.colour = {32, 24, 30, 30, 15.5, 11.5, {}};
    c.depth = {16, 12, 15, 15, 7.5, 5.5, {}};
    c.depth_clock_offset = offset;
    LogWriter log(drive());
    for (int i = 0; i < 10; ++i) {
      const Utime now = sample_start + i * frame_interval;
      if (i == 2) {
        camera_calibration_t m = to_message(c);
        m.utime = now;
        log.write(now, "CAMERA_CALIBRATION", encode_message(m));
      }
      RgbdFrame frame;
      frame.utime = now;
      frame.depth_utime = now + 4'000 - c.depth_offset();
      frame.colour = cv::Mat(24, 32, CV_8UC3, cv::Scalar(90, 100, 110));
      frame.depth = cv::Mat(12, 16, CV_16UC1, cv::Scalar(1500));
      stamps.emplace_back(frame.utime, frame.depth_utime);
      log.write(now, "CAMERA", encode_message(to_message(encode(frame, 90))));
    }
    log.close();
    scratch.write("head.yaml",
                  "colour: {width: 32, height: 24, fx: 30, fy: 30, cx: 15.5, cy: 11.5}\n"
                  "depth: {width: 16, height: 12, fx: 15, fy: 15, cx: 7.5, cy: 5.5}\n"
                  "colour_depth: {translation: [0, 0, 0], quaternion: [1, 0, 0, 0]}\n"
                  "depth_clock_offset: " +
                      std::to_string(offset) + "\n");
    result = export_mcap({drive()}, {exported(), true}, "zstd");
  }

  /// Stamps of the pairs that the exported file gives, and the calibration that they came with.
  std::vector<std::pair<Utime, Utime>> import(std::vector<std::string> options) {
    const std::string log = scratch.path() / "again.lcmlog";
    options.insert(options.begin(), {exported(), log, "--force"});
    const CommandRun run = run_command({"import", import_command}, options);
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    std::vector<std::pair<Utime, Utime>> found;
    for (const LogEvent& event : read_log(log)) {
      if (event.channel == "CAMERA_CALIBRATION")
        calibration =
            from_message(decode_message<camera_calibration_t>(event.data.data(), event.data.size()));
      if (event.channel != "CAMERA") continue;
      const EncodedFrame frame = from_message(decode_message<images_t>(event.data.data(), event.data.size()));
      found.emplace_back(frame.utime, frame.depth.utime);
    }
    return found;
  }
  std::string drive() const { return scratch.path() / "drive.lcmlog"; }
  std::string exported() const { return scratch.path() / "drive.mcap"; }

  ScratchFolder scratch;
  std::vector<std::pair<Utime, Utime>> stamps;
  McapExport result;
  RgbdCalibration calibration;
};

TEST_F(ExportedLog, HasItsPairsAndStampsAgainWhateverDepthsClock) {
  for (const double offset : {-0.08, 1.5, 0.0}) {
    stamps.clear();
    write_drive(offset);
    EXPECT_EQ(result.topics.count("/camera/depth/clock_offset"), offset == 0 ? 0U : 1U);
    for (const std::vector<std::string>& options :
         {std::vector<std::string>{}, {"--calibration", (scratch.path() / "head.yaml").string()}}) {
      EXPECT_EQ(import(options), stamps) << offset << ", " << options.size();
      EXPECT_NEAR(calibration.depth_clock_offset, offset, 1e-9);
    }
  }
}

TEST_F(ExportedLog, HasItsTruthOfTheSameBodyAgain) {
  const std::string truth = scratch.path() / "truth.lcmlog";
  for (const std::string body : {"camera", "robot"}) {
    write_drive(0);
    ground_truth_t told{};
    told.utime = sample_start;
    told.frame = "world";
    told.child_frame = body;
    told.T_frame_child = to_message(planar_pose(1, 2, 0.3));
    LogWriter log(truth);
    log.write(told.utime, "GROUND_TRUTH", encode_message(told));
    log.close();
    result = export_mcap({drive(), truth}, {exported(), true}, "zstd");
    import({});
    std::vector<std::string> bodies;
    for (const LogEvent& event : read_log(scratch.path() / "again.lcmlog")) {
      if (event.channel != "GROUND_TRUTH") continue;
      const auto found = decode_message<ground_truth_t>(event.data.data(), event.data.size());
      bodies.push_back(found.child_frame);
      EXPECT_TRUE(from_message(found.T_frame_child, "T").isApprox(planar_pose(1, 2, 0.3), 1e-9));
    }
    EXPECT_THAT(bodies, ElementsAre(body));
  }
}

/// Logs whose channels have more than one type, damage, and pieces of another's name.
class OddLogExport : public ::testing::Test {
 protected:
  static Bytes pose_message(Utime utime) {
    pose_t message{};
    message.utime = utime;
    message.orientation[0] = 1;
    return encode_message(message);
  }
  static Bytes truth_message(Utime utime) {
    ground_truth_t message{};
    message.utime = utime;
    message.frame = "world";
    message.child_frame = "robot";
    message.T_frame_child.quat[0] = 1;
    return encode_message(message);
  }
  McapExport exported() const { return export_mcap({log()}, {mcap(), true}, "zstd"); }
  std::string log() const { return scratch.path() / "odd.lcmlog"; }
  std::string mcap() const { return scratch.path() / "odd.mcap"; }

  ScratchFolder scratch;
};

TEST_F(OddLogExport, MessagesHaveTheSchemaOfTheirOwnType) {
  LogWriter writer(log());
  writer.write(sample_start, "POSE", pose_message(sample_start));
  writer.write(sample_start + 1, "POSE", truth_message(sample_start + 1));
  writer.write(sample_start + 2, "Pose", pose_message(sample_start + 2));
  writer.close();
  EXPECT_THAT(exported().topics, ElementsAre(Pair("/pose", 3)));
  std::vector<std::string> types;
  const auto file = open_recording(mcap());
  file->scan([&](const RecordedMessage& message, ByteView) {
    EXPECT_EQ(file->topics()[message.topic].name, "/pose");
    types.push_back(file->topics()[message.topic].type);
  });
  EXPECT_THAT(types,
              ElementsAre("nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseStamped", "nav_msgs/msg/Odometry"));
}

/// A pose that is cut short, in the place of its end whole events of a channel that no header names, and
/// behind it a header that is damaged: only who knows the type sees that the pose is none.
TEST_F(OddLogExport, WhatADamagedEventHidesIsExportedAndTheDamageListed) {
  LogWriter hidden(scratch.path() / "inner.lcmlog");
  for (int i = 0; i < 3; ++i) hidden.write(sample_start + i, "HIDDEN", pose_message(sample_start + i));
  hidden.close();
  const std::string inner = scratch.read("inner.lcmlog") + "end";
  Bytes cut = pose_message(sample_start);
  cut.resize(20);
  cut.insert(cut.end(), inner.begin(), inner.end());
  LogWriter writer(log());
  writer.write(sample_start, "POSE", pose_message(sample_start));
  writer.write(sample_start + 1, "POSE", cut);
  writer.write(sample_start + 2, "POSE", pose_message(sample_start));
  writer.write(sample_start + 3, "POSE", pose_message(sample_start));
  writer.close();
  const std::string bytes = scratch.read("odd.lcmlog"), sync = inner.substr(0, 4);
  damage(log(), bytes.rfind(sync, bytes.rfind(sync) - 1));
  ASSERT_THAT(scan_log(log()).channels, ElementsAre("POSE"));
  const McapExport result = exported();
  EXPECT_THAT(result.topics, ElementsAre(Pair("/hidden", 3), Pair("/pose", 2)));
  EXPECT_THAT(result.damages, Not(IsEmpty()));
}

TEST_F(OddLogExport, PiecesAreOfTheChannelThatTheyName) {
  LogWriter writer(log());
  for (part_t part : split_message("OTHER", pose_message(sample_start), sample_start, 1, 100))
    writer.write(sample_start, "X_PART", encode_message(part));
  writer.close();
  EXPECT_THAT(exported().topics, ElementsAre(Pair("/other", 1)));
  EXPECT_THAT(scan_log(log()).channels, ElementsAre("OTHER"));
}

}  // namespace
}  // namespace lcmslam
