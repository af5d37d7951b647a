#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>

#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tests/unit/tools/log_samples.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

using namespace testing;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Import : public ::testing::Test {
 protected:
  /// Numbered images of which `good` are whole; of the others the depth is no image.
  void make_recording(int frames, int good) const {
    for (const char* name : {"rgb", "depth"}) std::filesystem::create_directories(folder() / name);
    for (int i = 0; i < frames; ++i) {
      const std::string file = std::to_string(i) + ".png";
      cv::imwrite((folder() / "rgb" / file).string(), cv::Mat(24, 32, CV_8UC3, cv::Scalar(90, 100, 110)));
      if (i < good)
        cv::imwrite((folder() / "depth" / file).string(), cv::Mat(24, 32, CV_16UC1, cv::Scalar(1500)));
      else
        std::ofstream(folder() / "depth" / file) << "no image";
    }
    std::ofstream(folder() / "lcmslam.yaml") << "format: numbered\ncolour: rgb/%d.png\ndepth: depth/%d.png\n";
    std::ofstream(folder() / "calibration.yaml")
        << "colour: {width: 32, height: 24, fx: 30, fy: 30, cx: 15.5, cy: 11.5}\ndepth_registered: true\n";
  }
  CommandRun import(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {folder().string(), log()});
    return run_command({"import", import_command}, more);
  }
  std::filesystem::path folder() const { return scratch_.path() / "images"; }
  std::string log() const { return scratch_.path() / "a.lcmlog"; }

  ScratchFolder scratch_;
};

TEST_F(Import, ARepeatedWarningIsOneLineWithItsCount) {
  make_recording(40, 8);
  const CommandRun run = import();
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.out, AllOf(HasSubstr("32 frames were malformed"), HasSubstr("32 times, first "),
                             HasSubstr("depth/8.png: is not a whole JPEG"), Not(HasSubstr("depth/9.png"))));
  EXPECT_THAT(run.errors, Not(HasSubstr(".png")));
  EXPECT_EQ(count(read_log(log()), "CAMERA"), 8U);
}

TEST_F(Import, ReplacesALogOnlyByForceAndOnlyByAWholeOne) {
  make_recording(5, 0);
  scratch_.write("a.lcmlog", "precious");
  EXPECT_THAT(import().last_line(), AllOf(HasSubstr("a.lcmlog: exists"), HasSubstr("--force")));
  const CommandRun failed = import({"--force"});
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_THAT(failed.last_line(), AllOf(HasSubstr("no frame could be read"), HasSubstr("depth/0.png")));
  EXPECT_EQ(scratch_.read("a.lcmlog"), "precious");
  make_recording(5, 5);
  EXPECT_EQ(import({"--force"}).exit_code, 0);
  EXPECT_EQ(count(read_log(log()), "CAMERA"), 5U);
}

TEST_F(Import, OptionsThatMeanNothingToARecordingAreRefused) {
  make_recording(2, 2);
  for (const std::vector<std::string>& option :
       {std::vector<std::string>{"--twist"}, {"--colour-topic", "/rgb"}, {"--max-stamp-difference", "0.1"}})
    EXPECT_THAT(import(option).last_line(),
                AllOf(HasSubstr(option[0] + " is for ROS bags"), HasSubstr("a data set of images")));
  EXPECT_THAT(import({"--robot", "3"}).last_line(), HasSubstr("--robot is for UTIAS MRCLAM"));
  const std::string bag = scratch_.write("drive.bag", "");
  for (const std::vector<std::string>& option :
       {std::vector<std::string>{"--robot", "3"}, {"--repeat", "2"}, {"--description", bag}}) {
    std::vector<std::string> arguments = {bag, log()};
    arguments.insert(arguments.end(), option.begin(), option.end());
    EXPECT_THAT(run_command({"import", import_command}, arguments).last_line(),
                AllOf(HasSubstr(option[0] + " is for "), HasSubstr("drive.bag is a recording of ROS")));
  }
  EXPECT_FALSE(std::filesystem::exists(log()));
  EXPECT_EQ(import({"--repeat", "2", "--calibration", (folder() / "calibration.yaml").string()}).exit_code,
            0);
}

TEST_F(Import, SimulateReplacesNothingUnaskedEither) {
  scratch_.write("a.lcmlog", "precious");
  const CommandRun run =
      run_command({"simulate", simulate_command},
                  {source_folder() / "config/scenes/kitchen.yaml", log(), "--seconds", "0.3"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.last_line(), HasSubstr("--force"));
  EXPECT_EQ(scratch_.read("a.lcmlog"), "precious");
}

TEST_F(Import, SimulateTakesFractionsOfAFrameASecond) {
  const auto simulated = [&](const std::string& rate) {
    return run_command({"simulate", simulate_command}, {source_folder() / "config/scenes/kitchen.yaml", log(),
                                                        "--force", "--seconds", "1", "--rate", rate});
  };
  const CommandRun run = simulated("2.5");
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.out, HasSubstr("2 frames"));
  EXPECT_NE(simulated("300").exit_code, 0);
}

}  // namespace
}  // namespace lcmslam
