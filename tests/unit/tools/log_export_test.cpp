// What goes out to other people's viewers comes back.

#include <gtest/gtest.h>

#include <lcmslam/imaging/io/codec.hpp>
#include "tests/unit/tools/command_run.hpp"
#include "tests/unit/tools/log_samples.hpp"
#include "tools/commands.hpp"
#include "tools/log/mcap_export.hpp"

namespace lcmslam {
namespace {

using namespace testing;

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

}  // namespace
}  // namespace lcmslam
