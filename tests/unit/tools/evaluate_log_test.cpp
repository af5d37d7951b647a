// lcmslam evaluate on what logs hold besides poses: graphs, maps, several runs, damage.

#include <fstream>
#include <limits>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/graph_t.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/graph_teller.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/evaluate_fixture.hpp"
#include "tests/unit/tools/mounted_camera.hpp"
#include "tools/evaluate/pose_log.hpp"
#include "tools/evaluate/robot_truth.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using testing::estimate_message;
using testing::Evaluate;
using ::testing::HasSubstr;
using testing::MessageLog;
using testing::truth_message;

// A growing graph of keyframes, each at a pose.
class GraphMessage {
 public:
  explicit GraphMessage(std::size_t poses_per_keyframe) : stride_(poses_per_keyframe) {
    graph_.utime = graph_.seq = 0;
    graph_.sender = 5;
    graph_.frame = "map";
    graph_.map_revision = graph_.n_edges = 0;
  }
  void add(std::size_t i, const StampedPose& pose) {
    graph_node_t node;
    node.keyframe = static_cast<std::int32_t>(i / stride_);
    graph_.utime = node.keyframe_utime = pose.utime;
    node.T_map_camera = to_message(pose.T_world_body);
    graph_.nodes.push_back(node);
  }
  void remove(std::ptrdiff_t node) { graph_.nodes.erase(graph_.nodes.begin() + node); }
  std::size_t size() const { return graph_.nodes.size(); }
  const graph_t& message() {
    graph_.n_nodes = static_cast<std::int32_t>(graph_.nodes.size());
    return graph_;
  }
  /// With every keyframe where the path has it.
  const graph_t& corrected(const Trajectory& path) {
    for (graph_node_t& node : graph_.nodes)
      node.T_map_camera = to_message(path[stride_ * static_cast<std::size_t>(node.keyframe)].T_world_body);
    return message();
  }

 private:
  std::size_t stride_;
  graph_t graph_{};
};

TEST_F(Evaluate, ATruthThatWentThroughATextFileIsStillTheTruth) {
  write_log("run.lcmlog");
  for (const std::vector<std::string>& format : {std::vector<std::string>{}, {"--kitti"}}) {
    std::vector<std::string> arguments = {"--export", path("copy.txt"), path("run.lcmlog:GROUND_TRUTH")};
    arguments.insert(arguments.end(), format.begin(), format.end());
    ASSERT_EQ(run(arguments), 0) << output_;
    ASSERT_EQ(run({"--truth", path("run.lcmlog"), path("copy.txt"), "--estimate-frame", "camera"}), 0)
        << output_;
    EXPECT_THAT(output_, HasSubstr("MADE FROM GROUND TRUTH"));
  }
}

TEST_F(Evaluate, NamesWhereTheTruthIsWhereALogHasNone) {
  {
    MessageLog log(path("batch.lcmlog"));
    for (const StampedPose& pose : path_) log.write("ICP_POSE", estimate_message(pose));
  }
  EXPECT_NE(run({path("batch.lcmlog")}), 0);
  EXPECT_THAT(output_, AllOf(HasSubstr("has no channel GROUND_TRUTH; channels with poses: ICP_POSE"),
                             HasSubstr("--truth FILE")));
  EXPECT_EQ(run({}), 2);
  EXPECT_THAT(output_, HasSubstr("--truth FILE"));
}

// A mapper that walks off by 1 cm a pose, a keyframe every ten poses; its last graph has them right.
TEST_F(Evaluate, FinalPathFollowsTheLastGraph) {
  {
    MessageLog log(path("run.lcmlog"));
    for (const StampedPose& pose : path_) log.write("GROUND_TRUTH", truth_message(pose, "robot"));
    GraphMessage graph(10);
    const auto slid = [&](std::size_t i) {
      StampedPose pose = path_[i];
      pose.T_world_body = Eigen::Translation3d(0, 0, 0.01 * static_cast<double>(i)) * pose.T_world_body;
      return pose;
    };
    for (std::size_t i = 0; i < path_.size(); ++i) {
      if (i % 10 == 0) {
        graph.add(i, slid(i));
        log.write("ICP_GRAPH", graph.message());
      }
      log.write("ICP_POSE", estimate_message(slid(i)));
    }
    log.write("ICP_GRAPH", graph.corrected(path_));
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

// A graph that is larger than the recorder's buffer counts as any other.
TEST_F(Evaluate, FinalPathFollowsAGraphInPieces) {
  {
    MessageLog log(path("run.lcmlog"));
    const Eigen::Isometry3d aside(Eigen::Translation3d(0, 0.5, 0));  // of the map, until the last graph
    GraphMessage graph(5);
    for (std::size_t i = 0; i < path_.size(); ++i) {
      const StampedPose pose{path_[i].utime, aside * path_[i].T_world_body};
      log.write("GROUND_TRUTH", truth_message(path_[i], "robot"));
      if (i % 5 == 0) {
        graph.add(i, pose);
        log.write("ICP_GRAPH", graph.message());
      }
      log.write("ICP_POSE", estimate_message(pose));
    }
    log.write_in_pieces("ICP_GRAPH", graph.corrected(path_));
  }
  ASSERT_EQ(run({path("run.lcmlog:ICP_FINAL"), "--alignment", "none", "--json", path("out.json")}), 0)
      << output_;
  EXPECT_LT(ate(json("out.json").at("estimates").at(0)), 1e-6);
}

// Poses seen from nodes that the mapper has given up follow those that stayed.
TEST_F(Evaluate, FinalPathOutlivesNodesThatAreGivenUp) {
  {
    MessageLog log(path("run.lcmlog"));
    for (const StampedPose& pose : path_) log.write("GROUND_TRUTH", truth_message(pose, "robot"));
    GraphMessage graph(5);
    GraphTeller teller;
    const Eigen::Isometry3d aside(Eigen::Translation3d(0, 0.5, 0));  // of the map, until the last graph
    for (std::size_t i = 0; i < path_.size(); ++i) {
      const StampedPose pose{path_[i].utime, aside * path_[i].T_world_body};
      if (i % 5 == 0) {
        graph.add(i, pose);
        if (graph.size() > 4) graph.remove(1);
        const graph_t told = teller.tell(graph.message(), false);
        EXPECT_EQ(told.change, i == 0 ? 0 : 1);
        log.write("ICP_GRAPH", told);
      }
      log.write("ICP_POSE", estimate_message(pose));
    }
    log.write("ICP_GRAPH", teller.tell(graph.corrected(path_), false));
  }
  EXPECT_EQ(run({path("run.lcmlog"), "--alignment", "none", "--json", path("out.json")}), 0) << output_;
  const auto results = json("out.json").at("estimates");
  ASSERT_EQ(results.size(), 2U);
  EXPECT_EQ(results[1].at("name"), "ICP_FINAL");
  EXPECT_EQ(results[1].at("poses"), path_.size());
  EXPECT_NEAR(ate(results[0]), 0.5, 1e-3);
  EXPECT_LT(ate(results[1]), 1e-3);
}

TEST_F(Evaluate, MapIsComparedWithTheScene) {
  std::ofstream(path("map.ply")) << "ply\nformat ascii 1.0\nelement vertex 0\nend_header\n";
  write_log("run.lcmlog");
  EXPECT_NE(run({path("run.lcmlog"), "--map", path("map.ply")}), 0);  // without --scene
  EXPECT_NE(run({path("run.lcmlog"), "--scene", path("none.yaml"), "--map", path("map.ply")}), 0);
  ColouredCloud cloud;  // the kitchen's floor, 2 cm too high; the log's map lies elsewhere
  for (int i = 0; i < 400; ++i) {
    const int row = i / 20, column = i % 20;
    cloud.points.emplace_back(0.5f + 0.01f * static_cast<float>(column),
                              0.5f + 0.01f * static_cast<float>(row), 0.02f);
    cloud.colours.emplace_back(1, 2, 3);
  }
  save_ply(std::filesystem::path(path("map.ply")), cloud);
  Trajectory same = path_;
  write_tum(path("truth.txt"), same);
  for (StampedPose& pose : same) pose.T_world_body.translation().x() += 1e-7;
  write_tum(path("estimate.txt"), same);
  const std::string scene = source_folder() / "config/scenes/kitchen.yaml";
  EXPECT_EQ(run({"--truth", path("truth.txt"), path("estimate.txt"), "--map", path("map.ply"), "--scene",
                 scene, "--json", path("map.json")}),
            0)
      << output_;
  const auto figures = json("map.json").at("map");
  EXPECT_EQ(figures.at("points"), 400);
  EXPECT_NEAR(figures.at("median_m").get<double>(), 0.02, 1e-4);
  EXPECT_EQ(figures.at("beyond_share"), 0);
  EXPECT_THAT(output_, HasSubstr("400 points"));
  EXPECT_THAT(output_, HasSubstr("median 0.0200 m"));
}

TEST_F(Evaluate, MapIsComparedWithAReferenceLogsImages) {
  const RgbdCalibration calibration = testing::mounted_camera();
  {
    MessageLog log(path("run.lcmlog"));
    camera_calibration_t c = to_message(calibration);
    c.utime = c.seq = c.sender = 0;
    log.write("CAMERA_CALIBRATION", c);
    for (const StampedPose& pose : path_) log.write("GROUND_TRUTH", truth_message(pose, "robot"));
    for (const StampedPose& pose : path_) log.write("ICP_POSE", estimate_message(pose));
    RgbdFrame frame;  // a wall 2 m ahead of the camera at the path's first pose
    frame.utime = path_.front().utime;
    frame.depth_utime = frame.utime - static_cast<Utime>(std::llround(1e6 * calibration.depth_clock_offset));
    frame.colour = cv::Mat(calibration.colour.height, calibration.colour.width, CV_8UC3, cv::Scalar::all(9));
    frame.depth = cv::Mat(calibration.depth.height, calibration.depth.width, CV_16UC1, cv::Scalar(2000));
    frame.depth.row(frame.depth.rows - 1).setTo(1900);  // its skirting: one value alone is no depth
    log.write("CAMERA", to_message(encode(frame)));
  }
  const Eigen::Isometry3d T_world_depth =
      path_.front().T_world_body * calibration.T_robot_camera * calibration.T_colour_depth;
  ColouredCloud cloud;
  for (int i = 0; i < 400; ++i) {
    const int row = i / 20, column = i % 20;
    const Eigen::Vector3d p(0.01 * column, 0.01 * row, 1.97);
    cloud.points.emplace_back((T_world_depth * p).cast<float>());
    cloud.colours.emplace_back(1, 2, 3);
  }
  save_ply(std::filesystem::path(path("map.ply")), cloud);
  EXPECT_NE(run({path("run.lcmlog"), "--map", path("map.ply"), "--reference", path("none.lcmlog")}), 0);
  EXPECT_EQ(run({path("run.lcmlog"), "--map", path("map.ply"), "--reference", path("run.lcmlog")}), 0)
      << output_;
  EXPECT_THAT(output_, HasSubstr("400 points"));
  EXPECT_THAT(output_, HasSubstr("median 0.0300 m, 95 % within 0.0300 m"));
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
  ASSERT_EQ(run({path("run.lcmlog:ICP_POSE"), "--export", path("poses.txt")}), 0) << output_;
  EXPECT_THAT(output_, AllOf(HasSubstr(inputs.notes[0]), HasSubstr("120 poses")));
}

TEST_F(Evaluate, ACamerasTruthIsMovedToTheRobot) {
  write_log("run.lcmlog");
  const Trajectory truth = robot_truth(path("run.lcmlog"));
  ASSERT_EQ(truth.size(), path_.size());
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_TRUE(truth[i].T_world_body.isApprox(path_[i].T_world_body, 1e-6));
  write_log("bare.lcmlog", false);
  EXPECT_THROW(robot_truth(path("bare.lcmlog")), std::runtime_error);
}

// What a path's figures say is of the poses that they are of.
TEST_F(Evaluate, LostPosesOfAnEarlierMapAreNotThoseOfTheNewest) {
  {
    MessageLog log(path("run.lcmlog"));
    for (const StampedPose& pose : path_) log.write("GROUND_TRUTH", truth_message(pose, "robot"));
    for (std::size_t i = 0; i < path_.size(); ++i) {
      pose_estimate_t message = estimate_message(path_[i], i < 80 ? 5 : 6);
      if (i < 80) message.status = pose_estimate_t::LOST;
      if (i >= 197) message.status = i == 199 ? pose_estimate_t::LOST : pose_estimate_t::DEGRADED;
      log.write("ICP_POSE", message);
    }
  }
  const EvaluationInputs inputs = read("", {path("run.lcmlog")});
  EXPECT_EQ(inputs.estimates.at(0).lost, 1);
  EXPECT_EQ(inputs.estimates.at(0).degraded, 2);
  const PoseLog poses = read_pose_log(path("run.lcmlog"));
  EXPECT_EQ(poses.channels().at("ICP_POSE").earlier_lost, 80);
}

// The final path lacks what it cannot place, and says so.
TEST_F(Evaluate, FinalPathSaysWhatItLeavesOut) {
  {
    MessageLog log(path("run.lcmlog"));
    for (const StampedPose& pose : path_) log.write("GROUND_TRUTH", truth_message(pose, "robot"));
    GraphMessage graph(10);
    for (std::size_t i = 0; i < path_.size(); ++i) {
      if (i >= 50 && i % 10 == 0) {
        graph.add(i, path_[i]);
        log.write("ICP_GRAPH", graph.message());
      }
      pose_estimate_t message = estimate_message(path_[i]);
      message.map_revision = i < 30 ? 7 : 1;  // begins again
      if (i == 199) message.status = pose_estimate_t::DEGRADED;
      log.write("ICP_POSE", message);
    }
  }
  const EvaluationInputs inputs = read("", {path("run.lcmlog:ICP_FINAL")});
  EXPECT_EQ(inputs.estimates.at(0).trajectory.size(), 150U);
  EXPECT_EQ(inputs.estimates.at(0).degraded, 1);
  ASSERT_EQ(inputs.notes.size(), 2U);
  EXPECT_THAT(inputs.notes[0], HasSubstr("ICP_FINAL began again 1 time: only the newest map counts, 30"));
  EXPECT_THAT(inputs.notes[1], HasSubstr("ICP_FINAL: 20 poses without a keyframe before them left out"));
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

}  // namespace
}  // namespace lcmslam
