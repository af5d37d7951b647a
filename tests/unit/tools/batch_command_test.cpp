// `lcmslam batch` as a user meets it: what cannot succeed ends with an error whose last line names cause and
// cure.

#include <gmock/gmock.h>

#include <lcmslam/images_t.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/decode.hpp>
#include "tests/support/recordings.hpp"
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

using namespace testing;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

class BatchCommand : public ::testing::Test {
 protected:
  CommandRun batch(const std::string& log, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {source_folder() / "config/replay.yaml", log, "--to", "0.5"});
    if (std::find(more.begin(), more.end(), "--out") == more.end()) more.insert(more.end(), {"--out", out()});
    return run_command({"batch", batch_command}, more);
  }
  std::string out() const { return scratch_.path() / "out"; }

  /// The kitchen's log with some channels alone, and its images changed.
  std::string kitchen(
      const std::set<std::string>& channels,
      const std::function<void(images_t&)>& change = [](images_t&) {}) const {
    const std::string file = scratch_.path() / "changed.lcmlog";
    LogReader reader(own_log("kitchen.lcmlog"));
    LogWriter writer(file);
    while (const auto event = reader.next()) {
      if (channels.count(event->channel) == 0) continue;
      if (event->channel != "CAMERA") {
        writer.write(event->timestamp, event->channel, event->data);
        continue;
      }
      auto images = decode_message<images_t>(event->data.data(), event->data.size());
      change(images);
      writer.write(event->timestamp, event->channel, encode_message(images));
    }
    writer.close();
    return file;
  }

  ScratchFolder scratch_;
};

TEST_F(BatchCommand, WithoutCalibrationFailsBeforeAnyWork) {
  const CommandRun run = batch(kitchen({"CAMERA", "ENCODERS"}));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out, IsEmpty());
  EXPECT_THAT(run.last_line(), AllOf(StartsWith("lcmslam batch: "), HasSubstr("has no CAMERA_CALIBRATION"),
                                     HasSubstr("--calibration FILE"), HasSubstr("log calibrate")));
  EXPECT_FALSE(std::filesystem::exists(out()));
}

TEST_F(BatchCommand, AForeignLogFailsBeforeAnyTable) {
  const CommandRun run = batch(kitchen({"ENCODERS"}));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out, IsEmpty());
  EXPECT_THAT(run.last_line(),
              AllOf(HasSubstr("has no CAMERA (images_t)"), HasSubstr("ENCODERS (encoders_t)")));
}

TEST_F(BatchCommand, FramesThatAllAreRefusedFailWithTheCauseOnTheLastLine) {
  const CommandRun run = batch(kitchen({"CAMERA", "CAMERA_CALIBRATION", "ENCODERS"}, [](images_t& images) {
    images.images.erase(images.images.begin() + 1);
    images.image_types.erase(images.image_types.begin() + 1);
    --images.n_images;
  }));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.last_line(),
              AllOf(HasSubstr("refused 5 of 5 CAMERA messages"), HasSubstr("no depth image")));
  EXPECT_THAT(run.out, AllOf(Not(HasSubstr("maps beside it")), HasSubstr("no map was saved")));
}

TEST_F(BatchCommand, PrintsErrorsWhereTheLogHasTheTruth) {
  const std::set<std::string> without = {"CAMERA", "CAMERA_CALIBRATION", "ENCODERS"};
  EXPECT_THAT(batch(kitchen(without), {"--force"}).out, Not(HasSubstr("ATE")));
  std::set<std::string> with = without;
  with.insert("GROUND_TRUTH");
  const CommandRun run = batch(kitchen(with), {"--force"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.out, AllOf(HasSubstr("ATE rmse m"), HasSubstr("\nicp "), HasSubstr("\nfastslam ")));
}

// A farm hashes log and configuration when it begins; its runs read them hours later.
TEST_F(BatchCommand, ARunOfAFarmRefusesWhatHasChangedSinceItBegan) {
  const CommandRun run =
      batch(kitchen({"CAMERA", "CAMERA_CALIBRATION", "ENCODERS"}), {"--key", "of yesterday"});
  EXPECT_NE(run.exit_code, 0);
  EXPECT_THAT(run.last_line(), HasSubstr("is not what it was when the farm began"));
  EXPECT_FALSE(std::filesystem::exists(std::filesystem::path(out()) / "summary.json"));
}

TEST_F(BatchCommand, ACalibrationFromAFileMapsALogWithoutOne) {
  const std::string log = kitchen({"CAMERA", "ENCODERS"});
  // As simulated (libs/simulation): the head's size must fit, its numbers need not be exact here.
  const std::string head =
      scratch_.write("head.yaml",
                     "sensor: mine\n"
                     "colour: {width: 640, height: 480, fx: 554, fy: 554, cx: 319.5, cy: 239.5}\n"
                     "depth: {width: 176, height: 144, fx: 200, fy: 200, cx: 87.5, cy: 71.5}\n"
                     "colour_depth: {translation: [0.08, 0, 0], quaternion: [1, 0, 0, 0]}\n");
  const CommandRun run = batch(log, {"--calibration", head});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.out, AllOf(HasSubstr("sensor mine, colour 640x480, depth 176x144, hand-held (no mount)"),
                             HasSubstr("odometry: wheels, from ENCODERS"), HasSubstr("maps beside it")));
  EXPECT_TRUE(std::filesystem::exists(out() + "/icp_map.ply"));

  const CommandRun again = batch(log, {"--calibration", head});
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.last_line(), AllOf(HasSubstr(out()), HasSubstr("--force")));
  EXPECT_EQ(batch(log, {"--calibration", head, "--force"}).exit_code, 0);
}

TEST_F(BatchCommand, ACalibrationOfAnotherCameraFailsWithBothSizes) {
  const std::string head = scratch_.write(
      "ros.yaml", "image_width: 320\nimage_height: 240\nK: [250, 0, 160, 0, 250, 120, 0, 0, 1]\nD: []\n");
  const CommandRun run =
      batch(kitchen({"CAMERA", "CAMERA_CALIBRATION", "ENCODERS"}), {"--calibration", head});
  EXPECT_EQ(run.exit_code, 1) << "the log's own calibration was taken";
  EXPECT_THAT(run.last_line(),
              HasSubstr("the colour image is 640x480, by its calibration it must be 320x240"));
}

}  // namespace
}  // namespace lcmslam
