// What batch leaves beside the maps is what a live run leaves.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include <lcmslam/evaluation/pose_text.hpp>
#include <lcmslam/runtime/version.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/commands.hpp"
#include "tools/evaluate/pose_log.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Exit code; what is printed is kept.
int run(int (*command)(int, char**), std::vector<std::string> arguments, std::string& output) {
  std::vector<char*> argv;
  for (std::string& a : arguments) argv.push_back(a.data());
  ::testing::internal::CaptureStdout();
  const int code = command(static_cast<int>(argv.size()), argv.data());
  output = ::testing::internal::GetCapturedStdout();
  return code;
}

class RunFiles : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch_ = new testing::ScratchFolder;
    std::string output;
    code_ = run(batch_command,
                {"batch", source_folder() / "config/replay.yaml", source_folder() / "logs/kitchen.lcmlog",
                 "--to", "1.5", "--kitti", "--out", out().string(), "--set", "fastslam.particles=20"},
                output);
  }
  static void TearDownTestSuite() { delete scratch_; }
  static fs::path out() { return scratch_->path() / "out"; }

  static testing::ScratchFolder* scratch_;
  static int code_;
};

testing::ScratchFolder* RunFiles::scratch_ = nullptr;
int RunFiles::code_ = -1;

TEST_F(RunFiles, AreTrajectoriesMapsPicturesAndASummary) {
  ASSERT_EQ(code_, 0);
  for (const char* name : {"odometry.txt", "fastslam.txt", "icp.txt", "icp_kitti.txt", "icp_kitti_times.txt",
                           "trajectories.png", "summary.json", "icp_map.ply", "fastslam_map.ply",
                           "icp_front.png", "icp_top.png", "fastslam_top.png", "batch.lcmlog"})
    EXPECT_TRUE(fs::exists(out() / name)) << name;
}

TEST_F(RunFiles, TrajectoriesNameTheirFrames) {
  const PoseText icp = read_pose_text(out() / "icp.txt");
  EXPECT_EQ(icp.frame + "/" + icp.body, "map/robot");
  const PoseText odometry = read_pose_text(out() / "odometry.txt");
  EXPECT_EQ(odometry.frame + "/" + odometry.body, "odom/robot");
  EXPECT_EQ(read_pose_text(out() / "icp_kitti.txt").trajectory.size(), icp.trajectory.size());
  EXPECT_EQ(icp.trajectory.size(),
            read_pose_log((out() / "batch.lcmlog").string()).channel("ICP_POSE", "").trajectory.size());
}

TEST_F(RunFiles, SummaryHoldsVersionsConfigurationAndCalibration) {
  const auto summary = nlohmann::json::parse(scratch_->read("out/summary.json"));
  EXPECT_EQ(summary.at("version"), lcmslam_version);
  EXPECT_TRUE(summary.at("versions").contains("opencv"));
  EXPECT_TRUE(summary.at("configuration").contains("icp")) << "with what replay.yaml includes";
  EXPECT_EQ(summary.at("overrides").at(0), "fastslam.particles=20");
  EXPECT_NEAR(summary.at("calibration").at("T_robot_camera").at("trans").at(2), 1.3, 0.3);
  EXPECT_EQ(summary.at("frames"), 15);
  EXPECT_GT(summary.at("processes").at("map-server").at("values").at("keyframes"), 0);
  EXPECT_EQ(summary.at("paths").at("icp").at("poses"), read_tum(out() / "icp.txt").size());
}

TEST_F(RunFiles, LogCarriesTheCalibration) {
  // The same path as the camera's: with the log's own calibration both agree.
  const PoseLog log = read_pose_log((out() / "batch.lcmlog").string());
  ASSERT_TRUE(log.calibration());
  save_tum(out() / "camera.txt",
           in_other_frame(log.channel("ICP_POSE", "").trajectory, log.calibration()->T_robot_camera),
           {"", ""});
  std::string output;
  EXPECT_EQ(run(evaluate_command,
                {"evaluate", "--truth", out() / "camera.txt", "--truth-frame", "camera",
                 (out() / "batch.lcmlog").string() + ":ICP_POSE"},
                output),
            0);
  EXPECT_THAT(output, HasSubstr("0.000000")) << output;
}

}  // namespace
}  // namespace lcmslam
