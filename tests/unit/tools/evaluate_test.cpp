// lcmslam evaluate, from trajectories to figures.

#include <fstream>

#include <lcmslam/evaluation/pose_text.hpp>
#include "tests/support/full_disk.hpp"
#include "tests/support/recordings.hpp"
#include "tests/unit/evaluation/ate_by_definition.hpp"
#include "tests/unit/tools/evaluate_fixture.hpp"
#include "tools/evaluate/pose_log.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using testing::Evaluate;
using ::testing::HasSubstr;
using testing::MessageLog;
using ::testing::Not;
using testing::odometry_message;
using ::testing::StartsWith;
using testing::truth_message;

TEST_F(Evaluate, PublishedTrajectoryAgreesWithTheDefinition) {
  LCMSLAM_SKIP_WITHOUT("trajectories");
  const auto folder = recording_path("trajectories");
  const auto truth = folder / "freiburg1_xyz-groundtruth.txt",
             estimate = folder / "freiburg1_xyz-rgbdslam.txt";
  ASSERT_EQ(run({"--truth", truth, estimate, "--json", path("r.json")}), 0) << output_;
  const auto result = json("r.json").at("estimates").at(0);
  EXPECT_NEAR(ate(result), testing::ate_by_definition(truth, estimate, false).rmse, 1e-4);
  EXPECT_NEAR(ate(result), 0.013473, 1e-6) << "what the published tools give";
  EXPECT_THAT(output_, HasSubstr("0.013473"));
}

TEST_F(Evaluate, LogAloneComparesItsPosesWithItsTruthInTheRobotsFrame) {
  write_log("run.lcmlog");
  ASSERT_EQ(run({path("run.lcmlog"), "--json", path("r.json")}), 0) << output_;
  EXPECT_THAT(output_, AllOf(HasSubstr("speaks of the camera: converted to the robot"),
                             HasSubstr("CAMERA_CALIBRATION"),
                             HasSubstr("association interpolate (the truth's gaps of at most 0.2 s)")));
  const auto estimates = json("r.json").at("estimates");
  ASSERT_EQ(estimates.size(), 3U);
  EXPECT_EQ(estimates.at(0).at("name"), "FASTSLAM_POSE");
  EXPECT_NEAR(ate(estimates.at(0)), 0.02 * std::sqrt(3), 0.004);
  EXPECT_EQ(estimates.at(1).at("name"), "ICP_POSE");
  EXPECT_LT(ate(estimates.at(1)), 1e-6) << "1.3 m of lever arm would show";
  EXPECT_EQ(estimates.at(2).at("name"), "ODOMETRY");
  EXPECT_EQ(estimates.at(2).at("matched_poses"), 200);
}

// Names of files come from other systems, too: \xe9 is an e with an accent in Latin-1.
TEST_F(Evaluate, FiguresOfANameThatIsNotUtf8AreWritten) {
  write_log("run.lcmlog");
  std::filesystem::rename(path("run.lcmlog"), path("caf\xe9.lcmlog"));
  ASSERT_EQ(run({path("caf\xe9.lcmlog"), "--json", path("r.json")}), 0) << output_;
  EXPECT_EQ(json("r.json").at("estimates").size(), 3U);
}

TEST_F(Evaluate, AFullDiskKeepsTheOldFigures) {
  write_log("run.lcmlog");
  scratch_.write("r.json", "the old figures");
  const testing::FullDisk full(3000);  // enough for what is printed
  EXPECT_EQ(run({path("run.lcmlog"), "--json", path("r.json")}), -1);
  EXPECT_THAT(output_, HasSubstr("cannot save " + path("r.json") + ": File too large"));
  EXPECT_EQ(scratch_.read("r.json"), "the old figures");
}

TEST_F(Evaluate, CameraTruthWithoutACalibrationIsRefused) {
  write_log("run.lcmlog", false);
  EXPECT_EQ(run({path("run.lcmlog")}), -1);
  EXPECT_THAT(output_, AllOf(HasSubstr("run.lcmlog:GROUND_TRUTH"), HasSubstr("CAMERA_CALIBRATION")));
}

TEST_F(Evaluate, TextTruthOfTheCameraIsConvertedWhenSaidSo) {
  write_log("run.lcmlog");
  write_tum(path("truth.txt"), in_other_frame(path_, testing::mounted_camera().T_robot_camera));
  const std::vector<std::string> arguments = {"--truth", path("truth.txt"), path("run.lcmlog:ICP_POSE"),
                                              "--json", path("r.json")};
  ASSERT_EQ(run(arguments), 0);
  EXPECT_THAT(output_, HasSubstr("does not say whose pose it is: taken as the robot's"));
  EXPECT_GT(ate(json("r.json").at("estimates").at(0)), 0.1);
  auto with_frame = arguments;
  with_frame.insert(with_frame.end(), {"--truth-frame", "camera"});
  ASSERT_EQ(run(with_frame), 0);
  EXPECT_LT(ate(json("r.json").at("estimates").at(0)), 1e-6);
}

TEST_F(Evaluate, CameraAgainstRobotIsNoticedAndTheOptionNamed) {
  const Eigen::Isometry3d T_robot_camera = testing::mounted_camera().T_robot_camera;
  write_tum(path("truth.txt"), in_other_frame(path_, T_robot_camera));
  write_tum(path("icp.txt"), path_);
  ASSERT_EQ(run({"--truth", path("truth.txt"), path("icp.txt"), "--json", path("r.json")}), 0);
  EXPECT_THAT(output_,
              AllOf(HasSubstr("icp: the truth's poses are not those of the estimate's body"),
                    HasSubstr("constantly turned by"), HasSubstr("-y, -z, +x"),
                    HasSubstr("--truth-frame camera --estimate-frame robot"), HasSubstr("--calibration")));
  EXPECT_TRUE(json("r.json").at("estimates").at(0).at("body_offset").at("rotated"));

  ASSERT_EQ(run({"--truth", path("truth.txt"), path("icp.txt"), "--align-bodies", "--json", path("r.json")}),
            0);
  EXPECT_LT(ate(json("r.json").at("estimates").at(0)), 1e-3);
  EXPECT_THAT(output_, HasSubstr("That is taken away above"));

  write_tum(path("same.txt"), in_other_frame(path_, T_robot_camera));
  ASSERT_EQ(run({"--truth", path("truth.txt"), path("same.txt")}), 0);
  EXPECT_THAT(output_, Not(HasSubstr("constantly")));
}

TEST_F(Evaluate, CalibrationMayComeFromAFileOrAnotherLog) {
  write_log("run.lcmlog");
  write_tum(path("truth.txt"), in_other_frame(path_, testing::mounted_camera().T_robot_camera));
  save_tum(path("icp.txt"), path_, {"map", "robot"});
  const std::vector<std::string> arguments = {"--truth", path("truth.txt"), path("icp.txt"), "--truth-frame",
                                              "camera",  "--json",          path("r.json")};
  EXPECT_EQ(run(arguments), -1);
  EXPECT_THAT(output_, HasSubstr("--calibration names"));
  auto with_log = arguments;
  with_log.insert(with_log.end(), {"--calibration", path("run.lcmlog")});
  ASSERT_EQ(run(with_log), 0) << output_;
  EXPECT_LT(ate(json("r.json").at("estimates").at(0)), 1e-6);
}

TEST_F(Evaluate, ExportWritesAChannelInEitherFormat) {
  write_log("run.lcmlog");
  ASSERT_EQ(run({path("run.lcmlog:FASTSLAM_POSE"), "--export", path("poses.txt")}), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("200 poses, body: robot, frame: map"));
  const PoseText tum = read_pose_text(path("poses.txt"));
  EXPECT_EQ(tum.frame + "/" + tum.body, "map/robot");
  ASSERT_EQ(run({path("run.lcmlog:FASTSLAM_POSE"), "--export", path("kitti.txt"), "--kitti"}), 0) << output_;
  const PoseText kitti = read_pose_text(path("kitti.txt"));
  EXPECT_EQ(kitti.format, PoseFormat::kitti);
  ASSERT_EQ(tum.trajectory.size(), 200U);
  ASSERT_EQ(kitti.trajectory.size(), 200U);
  EXPECT_EQ(kitti.trajectory[7].utime, tum.trajectory[7].utime);
  ASSERT_EQ(run({"--truth", path("poses.txt"), path("kitti.txt"), "--json", path("r.json")}), 0) << output_;
  EXPECT_LT(ate(json("r.json").at("estimates").at(0)), 1e-6);
}

// As where paths are compared: who says whose poses these are is believed, and told what the file says.
TEST_F(Evaluate, ExportKnowsWhosePosesByTheOption) {
  write_log("run.lcmlog");
  const std::vector<std::string> of_camera = {"--estimate-frame", "camera", "--export", path("poses.txt")};
  const auto exported = [&](const std::string& estimate) {
    std::vector<std::string> arguments = {estimate};
    arguments.insert(arguments.end(), of_camera.begin(), of_camera.end());
    EXPECT_EQ(run(arguments), 0) << output_;
    return read_pose_text(path("poses.txt")).body;
  };
  EXPECT_EQ(exported(path("run.lcmlog:ICP_POSE")), "camera");
  EXPECT_THAT(output_,
              HasSubstr("says that its poses are the robot's; by --estimate-frame they are the camera's"));
  ASSERT_EQ(run({path("run.lcmlog:ICP_POSE"), "--export", path("robot.txt")}), 0) << output_;
  EXPECT_EQ(exported(path("robot.txt")), "camera");
  EXPECT_THAT(output_, HasSubstr("robot.txt says that its poses are the robot's"));
}

TEST_F(Evaluate, ExportSaysWhatItLacks) {
  write_log("run.lcmlog");
  EXPECT_EQ(run({path("run.lcmlog"), "--export", path("poses.txt")}), -1);
  EXPECT_THAT(output_, HasSubstr("name the channel"));
  EXPECT_EQ(run({path("run.lcmlog:CAMERA_CALIBRATION"), "--export", path("poses.txt")}), -1);
  EXPECT_THAT(output_, HasSubstr("channels with poses: FASTSLAM_POSE"));
  EXPECT_EQ(run({"--export", path("poses.txt")}), -1);
  EXPECT_FALSE(std::filesystem::exists(path("poses.txt")));
}

TEST_F(Evaluate, ClockOffsetIsReportedBesideNotApplied) {
  write_tum(path("truth.txt"), path_);
  Trajectory late = path_;
  for (StampedPose& pose : late) pose.utime += 120'000;
  write_tum(path("late.txt"), late);
  const std::vector<std::string> files = {"--truth", path("truth.txt"), path("late.txt"), "--json",
                                          path("r.json")};
  ASSERT_EQ(run(files), 0);
  const double plain = ate(json("r.json").at("estimates").at(0));
  auto search = files;
  search.push_back("--estimate-clock-offset");
  ASSERT_EQ(run(search), 0);
  EXPECT_THAT(output_, AllOf(HasSubstr("clock -120.0 ms"), HasSubstr("not applied above")));
  const auto result = json("r.json").at("estimates").at(0);
  EXPECT_EQ(ate(result), plain) << "the figures themselves are those without an offset";
  EXPECT_NEAR(result.at("estimated_clock_offset").at("offset_s").get<double>(), -0.12, 2e-3);
  EXPECT_LT(ate(result.at("estimated_clock_offset").at("with_it")), 0.05 * plain);

  auto given = files;
  given.insert(given.end(), {"--clock-offset", "-0.12"});
  ASSERT_EQ(run(given), 0);
  EXPECT_LT(ate(json("r.json").at("estimates").at(0)), 1e-6);
  given.push_back("--estimate-clock-offset");
  EXPECT_EQ(run(given), 2) << "given and estimated exclude each other";
}

TEST_F(Evaluate, EstimateMadeFromTruthIsSaidFirst) {
  write_tum(path("truth.txt"), path_);
  scratch_.write("labelled.txt", "# ground truth trajectory\n1 0 0 0 0 0 0 1\n");
  Random random(1);
  write_tum(path("honest.txt"), testing::with_noise(path_, random, 0.01, 0));
  write_tum(path("copy.txt"), path_);
  ASSERT_EQ(run({"--truth", path("truth.txt"), path("honest.txt"), path("copy.txt")}), 0);
  EXPECT_THAT(output_,
              AllOf(StartsWith("MADE FROM GROUND TRUTH"), HasSubstr("copy (its poses are the truth's)"),
                    Not(HasSubstr("nothing: honest"))));
  EXPECT_EQ(run({"--truth", path("truth.txt"), path("labelled.txt")}), 1);  // no common time
  EXPECT_THAT(output_, AllOf(StartsWith("MADE FROM GROUND TRUTH"), HasSubstr("labelled.txt:1 says so")));
}

TEST_F(Evaluate, OdometryThatNamesTheTruthAsItsSourceIsSaidFirst) {
  {
    MessageLog log(path("fed.lcmlog"));
    Random random(1);
    for (const StampedPose& pose : path_) log.write("GROUND_TRUTH", truth_message(pose, "robot"));
    for (const StampedPose& pose : testing::with_noise(path_, random, 0.01, 0))
      log.write("ODOMETRY", odometry_message(pose, "ground truth"));
  }
  ASSERT_EQ(run({path("fed.lcmlog")}), 0);
  EXPECT_THAT(output_, StartsWith("MADE FROM GROUND TRUTH, its errors prove nothing: ODOMETRY"));
  ASSERT_EQ(
      run({path("fed.lcmlog"), "--estimate", path("fed.lcmlog:GROUND_TRUTH"), "--truth", path("fed.lcmlog")}),
      0);
  EXPECT_THAT(output_, HasSubstr("GROUND_TRUTH (it is a channel of ground truth)"));
}
TEST_F(Evaluate, WrongInputIsNamed) {
  write_tum(path("truth.txt"), path_);
  scratch_.write("bad.txt", "# t x y z\n1 0 0 0 0 0 0 1\n2 0 0 x 0 0 0 1\n");
  scratch_.write("empty.txt", "# nothing\n");
  EXPECT_EQ(run({"--truth", path("truth.txt"), path("bad.txt")}), -1);
  EXPECT_THAT(output_, AllOf(HasSubstr("bad.txt:3"), HasSubstr("'x' is not a number")));
  EXPECT_EQ(run({"--truth", path("truth.txt"), path("empty.txt")}), -1);
  EXPECT_THAT(output_, HasSubstr("empty.txt: has no poses"));
  EXPECT_EQ(run({"--truth", path("truth.txt"), path("missing.txt")}), -1);
  EXPECT_THAT(output_, HasSubstr("missing.txt: cannot be opened"));
  EXPECT_EQ(run({path("bad.txt")}), -1);
  EXPECT_THAT(output_, HasSubstr("--truth"));
  EXPECT_EQ(run({"--truth", path("truth.txt")}), -1);
  EXPECT_THAT(output_, HasSubstr("no estimates"));
  EXPECT_EQ(run({"--truth", path("truth.txt"), path("truth.txt:ICP_POSE")}), -1);
  EXPECT_THAT(output_, HasSubstr("is no LCM log"));
  EXPECT_EQ(run({"--truth", path("truth.txt"), path("truth.txt"), "--alignment", "affine"}), 2);
  EXPECT_EQ(run({"--truth", path("truth.txt"), path("truth.txt"), "--plot", path("plot.gif")}), 2);
}

TEST_F(Evaluate, AlignmentsAndPlots) {
  write_tum(path("truth.txt"), path_);
  Trajectory scaled = testing::moved(path_, planar_pose(1, 2, 0.5));
  for (StampedPose& pose : scaled) pose.T_world_body.translation() *= 0.5;
  write_tum(path("scaled.txt"), scaled);
  ASSERT_EQ(run({"--truth", path("truth.txt"), path("scaled.txt"), "--alignment", "sim3", "--json",
                 path("r.json"), "--plot", path("p.png"), path("p.svg")}),
            0)
      << output_;
  const auto result = json("r.json").at("estimates").at(0);
  EXPECT_LT(ate(result), 1e-6);
  EXPECT_NEAR(result.at("alignment").at("scale").get<double>(), 2, 1e-6);
  EXPECT_GT(std::filesystem::file_size(path("p.png")), 1000U);
  EXPECT_THAT(scratch_.read("p.svg"), AllOf(StartsWith("<svg "), HasSubstr(">scaled</text>")));
  double last = 1e-6;  // every freedom less leaves a larger error
  for (const std::string alignment : {"se3", "se2", "none"}) {
    ASSERT_EQ(run({"--truth", path("truth.txt"), path("scaled.txt"), "--alignment", alignment, "--json",
                   path("r.json")}),
              0);
    const double error = ate(json("r.json").at("estimates").at(0));
    EXPECT_GE(error, last) << alignment;
    last = error;
  }
}

// A filter that claims to err by nothing is not judged by the poses of which it claims less.
TEST_F(Evaluate, PosesWithoutACovarianceAreCounted) {
  {
    MessageLog log(path("run.lcmlog"));
    for (std::size_t i = 0; i < path_.size(); ++i) {
      log.write("GROUND_TRUTH", testing::truth_message(path_[i], "robot"));
      pose_estimate_t message = testing::estimate_message(path_[i]);
      if (i < 150) std::fill(std::begin(message.covariance), std::end(message.covariance), 0);
      log.write("ICP_POSE", message);
    }
  }
  ASSERT_EQ(run({path("run.lcmlog"), "--json", path("r.json")}), 0) << output_;
  EXPECT_THAT(output_,
              HasSubstr("consistency of its covariances (of 50 of 200 poses, others bring none): NEES"));
  EXPECT_EQ(json("r.json").at("estimates").at(0).at("consistency").at("poses"), 50);
}

TEST_F(Evaluate, EstimatesOfSeveralLogsAreToldApart) {
  write_log("a.lcmlog");
  write_log("b.lcmlog");
  const EvaluationInputs inputs = read(path("a.lcmlog"), {path("a.lcmlog"), path("b.lcmlog:ICP_POSE")});
  std::vector<std::string> names;
  for (const EvaluatedPath& e : inputs.estimates) names.push_back(e.name);
  EXPECT_THAT(names, ::testing::ElementsAre("FASTSLAM_POSE", "a:ICP_POSE", "ODOMETRY", "b:ICP_POSE"));
}

}  // namespace
}  // namespace lcmslam
