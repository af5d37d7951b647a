// lcmslam evaluate, from files and logs to figures.

#include <gmock/gmock.h>

#include <fstream>
#include <lcmslam/graph_t.hpp>
#include <limits>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "evaluate/evaluation_report.hpp"
#include "evaluate/pose_log.hpp"
#include "log/log_writer.hpp"
#include "mapping/map_export.hpp"
#include "messages/camera_messages.hpp"
#include "messages/decode.hpp"
#include "messages/geometry_messages.hpp"
#include "messages/motion_messages.hpp"
#include "unit/evaluation/ate_by_definition.hpp"
#include "unit/evaluation/path_samples.hpp"
#include "unit/tools/mounted_camera.hpp"
#include "unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// Writes messages with their own times.
class MessageLog {
 public:
  explicit MessageLog(const std::string& file) : log_(file) {}
  ~MessageLog() { log_.close(); }

  template <class M>
  void write(const std::string& channel, const M& message) {
    log_.write(message.utime, channel, encode_message(message));
  }
  void write_bytes(const std::string& channel, Utime utime, const std::vector<std::uint8_t>& bytes) {
    log_.write(utime, channel, bytes);
  }

 private:
  LogWriter log_;
};

ground_truth_t truth_message(const StampedPose& pose, const std::string& body) {
  ground_truth_t m;
  m.utime = pose.utime;
  m.seq = m.sender = 0;
  m.frame = "world";
  m.child_frame = body;
  m.T_frame_child = to_message(pose.T_world_body);
  return m;
}

pose_estimate_t estimate_message(const StampedPose& pose, std::int64_t sender = 5) {
  pose_estimate_t m = make_pose_estimate(pose.utime, pose.T_world_body, Matrix6d::Identity());
  m.seq = 0;
  m.sender = sender;
  return m;
}

odometry_t odometry_message(const StampedPose& pose, const std::string& source = "wheels") {
  MotionSample sample;
  sample.utime = pose.utime;
  sample.T_odom_robot = pose.T_world_body;
  sample.covariance = Matrix6d::Identity();
  odometry_t m = to_message(sample, source);
  m.seq = 0;
  m.sender = 5;
  return m;
}

class Evaluate : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (scratch_.path() / name).string(); }

  /// The command's exit code; its output is kept.
  int run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "evaluate");
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    int code = -1;
    try {
      code = evaluate_command(static_cast<int>(argv.size()), argv.data());
      output_.clear();
    } catch (const std::exception& error) {
      output_ = error.what();
    }
    output_ += ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
    return code;
  }
  nlohmann::json json(const std::string& name) const { return nlohmann::json::parse(scratch_.read(name)); }
  static double ate(const nlohmann::json& result) {
    return result.at("ate").at("translation").at("rmse_m").get<double>();
  }
  /// The estimates that the inputs' reader finds, by the notes it makes.
  EvaluationInputs read(const std::string& truth, std::vector<std::string> estimates) const {
    return read_inputs({truth, std::move(estimates), "", ""});
  }

  /// A log with a truth of the camera, two mappers and odometry in worlds of their own.
  void write_log(const std::string& name, bool with_calibration = true) {
    MessageLog log(path(name));
    if (with_calibration) {
      camera_calibration_t c = to_message(testing::mounted_camera());
      c.utime = c.seq = c.sender = 0;
      log.write("CAMERA_CALIBRATION", c);
    }
    Random random(3);
    for (const StampedPose& pose : path_) {
      StampedPose camera = pose;
      camera.T_world_body = pose.T_world_body * testing::mounted_camera().T_robot_camera;
      log.write("GROUND_TRUTH", truth_message(camera, "camera"));
    }
    const Eigen::Isometry3d T_map_world = testing::random_pose(random);
    for (const StampedPose& pose : testing::moved(path_, T_map_world)) {
      log.write("ICP_POSE", estimate_message(pose));
      log.write("ODOMETRY", odometry_message(pose));
    }
    for (const StampedPose& pose : testing::with_noise(path_, random, 0.02, 0))
      log.write("FASTSLAM_POSE", estimate_message(pose));
  }

  testing::ScratchFolder scratch_;
  const Trajectory path_ = testing::curved_path(200);
  std::string output_;
};

TEST_F(Evaluate, PublishedTrajectoryAgreesWithTheDefinition) {
  const auto folder = testing::data_folder("trajectories");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there: set LCMSLAM_DATA";
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
  EXPECT_THAT(output_, AllOf(HasSubstr("speaks of the camera: told of the robot"),
                             HasSubstr("CAMERA_CALIBRATION"), HasSubstr("association interpolate")));
  const auto estimates = json("r.json").at("estimates");
  ASSERT_EQ(estimates.size(), 3U);
  EXPECT_EQ(estimates.at(0).at("name"), "FASTSLAM_POSE");
  EXPECT_NEAR(ate(estimates.at(0)), 0.02 * std::sqrt(3), 0.004);
  EXPECT_EQ(estimates.at(1).at("name"), "ICP_POSE");
  EXPECT_LT(ate(estimates.at(1)), 1e-6) << "1.3 m of lever arm would show";
  EXPECT_EQ(estimates.at(2).at("name"), "ODOMETRY");
  EXPECT_EQ(estimates.at(2).at("matched_poses"), 200);
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
  auto told = arguments;
  told.insert(told.end(), {"--truth-frame", "camera"});
  ASSERT_EQ(run(told), 0);
  EXPECT_LT(ate(json("r.json").at("estimates").at(0)), 1e-6);
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

// A mapper that walks off by 1 cm a pose, a keyframe every ten poses; its last graph has them right.
TEST_F(Evaluate, FinalPathFollowsTheLastGraph) {
  {
    MessageLog log(path("run.lcmlog"));
    for (const StampedPose& pose : path_) log.write("GROUND_TRUTH", truth_message(pose, "robot"));
    graph_t graph;
    graph.utime = graph.seq = 0;
    graph.sender = 5;
    graph.frame = "map";
    graph.map_revision = 0;
    graph.n_edges = 0;
    const auto slid = [&](std::size_t i) {
      StampedPose pose = path_[i];
      pose.T_world_body = Eigen::Translation3d(0, 0, 0.01 * static_cast<double>(i)) * pose.T_world_body;
      return pose;
    };
    for (std::size_t i = 0; i < path_.size(); ++i) {
      if (i % 10 == 0) {
        graph_node_t node;
        node.keyframe = static_cast<std::int32_t>(i / 10);
        graph.utime = node.keyframe_utime = path_[i].utime;
        node.T_map_camera = to_message(slid(i).T_world_body);
        graph.nodes.push_back(node);
        graph.n_nodes = static_cast<std::int32_t>(graph.nodes.size());
        log.write("ICP_GRAPH", graph);
      }
      log.write("ICP_POSE", estimate_message(slid(i)));
    }
    for (std::size_t k = 0; k < graph.nodes.size(); ++k)
      graph.nodes[k].T_map_camera = to_message(path_[10 * k].T_world_body);
    log.write("ICP_GRAPH", graph);
  }
  EXPECT_EQ(run({path("run.lcmlog"), "--json", path("out.json")}), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("ICP_FINAL"));
  const auto results = json("out.json").at("estimates");
  ASSERT_EQ(results.size(), 2U);
  EXPECT_EQ(results[1].at("name"), "ICP_FINAL");
  EXPECT_EQ(results[1].at("poses"), path_.size());
  EXPECT_LT(ate(results[1]), 0.05);  // what is left: up to 9 cm within ten poses
  EXPECT_GT(ate(results[0]), 3 * ate(results[1]));
}

TEST_F(Evaluate, MapIsComparedWithTheScene) {
  std::ofstream(path("map.ply")) << "ply\nformat ascii 1.0\nelement vertex 0\nend_header\n";
  write_log("run.lcmlog");
  EXPECT_NE(run({path("run.lcmlog"), "--map", path("map.ply")}), 0);  // without --scene
  EXPECT_NE(run({path("run.lcmlog"), "--scene", path("none.yaml"), "--map", path("map.ply")}), 0);
  ColouredCloud cloud;  // the kitchen's floor, 2 cm too high; the log's map lies elsewhere
  for (int i = 0; i < 400; ++i) {
    cloud.points.emplace_back(0.5f + 0.01f * static_cast<float>(i % 20),
                              0.5f + 0.01f * static_cast<float>(i / 20), 0.02f);
    cloud.colours.emplace_back(1, 2, 3);
  }
  save_ply(path("map.ply"), cloud);
  Trajectory same = path_;
  write_tum(path("truth.txt"), same);
  for (StampedPose& pose : same) pose.T_world_body.translation().x() += 1e-7;
  write_tum(path("estimate.txt"), same);
  const std::string scene = std::string(LCMSLAM_SOURCE_DIR) + "/config/scenes/kitchen.yaml";
  EXPECT_EQ(
      run({"--truth", path("truth.txt"), path("estimate.txt"), "--map", path("map.ply"), "--scene", scene}),
      0)
      << output_;
  EXPECT_THAT(output_, HasSubstr("400 points"));
  EXPECT_THAT(output_, HasSubstr("median 0.0200 m"));
}

TEST_F(Evaluate, OnlyTheNewestMapOfARestartedMapperCounts) {
  {
    MessageLog log(path("run.lcmlog"));
    for (const StampedPose& pose : path_) log.write("GROUND_TRUTH", truth_message(pose, "robot"));
    for (std::size_t i = 0; i < path_.size(); ++i) {
      StampedPose pose = path_[i];
      if (i < 80) pose.T_world_body = planar_pose(5, 1, 2) * pose.T_world_body;
      log.write("ICP_POSE", estimate_message(pose, i < 80 ? 5 : 6));
    }
  }
  const EvaluationInputs inputs = read("", {path("run.lcmlog")});
  ASSERT_EQ(inputs.estimates.size(), 1U);
  EXPECT_EQ(inputs.estimates[0].trajectory.size(), 120U);
  ASSERT_EQ(inputs.notes.size(), 1U);
  EXPECT_THAT(inputs.notes[0], HasSubstr("began again 1 time: only the newest map counts, 80 earlier poses"));
}

TEST_F(Evaluate, OfSeveralRunsInALogOnlyTheNewestTruthCounts) {
  {
    MessageLog log(path("runs.lcmlog"));
    for (const int run : {0, 1})
      for (StampedPose pose : path_) {
        pose.utime += run * 7'000;  // stamps of the two runs lie between each other
        if (run == 0) pose.T_world_body = planar_pose(5, 1, 2) * pose.T_world_body;
        log.write("GROUND_TRUTH", truth_message(pose, "robot"));
        log.write("ICP_POSE", estimate_message(pose));
      }
  }
  ASSERT_EQ(run({path("runs.lcmlog"), "--json", path("runs.json")}), 0) << output_;
  EXPECT_LT(ate(json("runs.json").at("estimates").at(0)), 1e-6);
  EXPECT_THAT(output_, HasSubstr("GROUND_TRUTH began again 1 time"));
}

TEST_F(Evaluate, TooFewPosesForTheAlignmentProveNothing) {
  write_tum(path("truth.txt"), path_);
  write_tum(path("two.txt"), testing::moved({path_[0], path_[1]}, planar_pose(1, 2, 3)));
  EXPECT_EQ(run({"--truth", path("truth.txt"), path("two.txt")}), 1);
  EXPECT_THAT(output_, HasSubstr("only 2 poses"));
  EXPECT_EQ(run({"--truth", path("truth.txt"), path("two.txt"), "--alignment", "none"}), 0) << output_;
}

TEST_F(Evaluate, DamagedMessagesAreCountedForeignOnesNamed) {
  {
    MessageLog log(path("run.lcmlog"));
    log.write_bytes("FOREIGN", 1, {1, 2, 3, 4, 5, 6, 7, 8, 9});
    for (const StampedPose& pose : path_) {
      log.write("GROUND_TRUTH", truth_message(pose, "robot"));
      log.write("ICP_POSE", estimate_message(pose));
    }
    auto bytes = encode_message(estimate_message(path_.front()));
    bytes.pop_back();
    log.write_bytes("ICP_POSE", 2, bytes);
    auto far = estimate_message(path_.front());
    far.utime = std::numeric_limits<Utime>::max();  // would overflow what is computed with it
    log.write("ICP_POSE", far);
  }
  const EvaluationInputs inputs = read("", {path("run.lcmlog")});
  EXPECT_EQ(inputs.estimates.at(0).trajectory.size(), path_.size());
  ASSERT_EQ(inputs.notes.size(), 1U);
  EXPECT_THAT(inputs.notes[0], HasSubstr("2 messages could not be decoded"));
  EXPECT_EQ(run({path("run.lcmlog:FOREIGN"), "--truth", path("run.lcmlog")}), -1);
  EXPECT_THAT(output_, AllOf(HasSubstr("carries no poses but fingerprint 0102030405060708"),
                             HasSubstr("channels with poses: GROUND_TRUTH, ICP_POSE")));
}

TEST_F(Evaluate, WhatIsWholeOfADamagedLogCounts) {
  write_log("run.lcmlog");
  std::string bytes = scratch_.read("run.lcmlog");
  bytes.erase(bytes.size() / 2, 40);
  scratch_.write("run.lcmlog", bytes);
  ASSERT_EQ(run({path("run.lcmlog"), "--json", path("r.json")}), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("run.lcmlog is damaged in 1 place"));
  EXPECT_LT(ate(json("r.json").at("estimates").at(1)), 1e-6);
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
