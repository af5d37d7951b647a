// Raw data is what is logged: stock lcm-logplayer replays a log into a graph without camera, stock
// lcm-logger records one.

#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <lcm/lcm-cpp.hpp>

#include <lcmslam/images_t.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"

namespace lcmslam::integration {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Results must never be replayed: they would mix with those of the running graph.
const char* const raw_channels = "^(CAMERA|CAMERA_CALIBRATION|ENCODERS|GROUND_TRUTH)$";

struct LogFacts {
  std::map<std::string, int> events;
  std::int64_t last_frame = 0;  // utime
};

LogFacts read_log(const std::string& file) {
  LogFacts facts;
  lcm::LogFile log(file, "r");
  if (!log.good()) return facts;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    ++facts.events[event->channel];
    const auto* data = static_cast<const std::uint8_t*>(event->data);
    if (event->channel == "CAMERA")
      facts.last_frame = decode_message<images_t>(data, static_cast<std::size_t>(event->datalen)).utime;
  }
  return facts;
}

class Replay : public testing::Test {
 protected:
  static std::string url() { return lcm_url_from_environment(); }

  void start_graph(const std::string& lcm_url = url(),
                   const std::filesystem::path& config = source_folder() / "config/replay.yaml") {
    graph_.emplace(std::vector<std::string>{"lcmslam", "launch", config, "--lcm-url", lcm_url, "--out",
                                            folder_.path(), "--set",
                                            "map-server.folder=" + (folder_ / "maps").string()});
    for (const std::string process : {"surf", "odometry", "fastslam", "icp", "map-server"})
      ASSERT_TRUE(bus_.wait_for_status(
          process, [](const status_t& s) { return s.state == status_t::RUNNING; }, 60))
          << process << "\n"
          << graph_->output();
  }

  bool reached(const std::string& channel, std::int64_t utime) const {
    const auto pose = bus_.newest<pose_estimate_t>(channel);
    return pose && pose->utime >= utime;
  }

  /// Plays the log; both mappers must come to its end.
  void play(const std::string& log) {
    const LogFacts facts = read_log(log);
    ASSERT_GT(facts.last_frame, 0) << log;
    Program player({"lcm-logplayer", "-l", url(), log});
    const Ending ending = player.wait(120);
    ASSERT_EQ(ending.exit_code, 0) << player.output();
    // The last frames wait for odometry that may not come: what is 0.5 s before the end must be mapped.
    const std::int64_t end = facts.last_frame - 500'000;
    EXPECT_TRUE(wait_until([&] { return reached("FASTSLAM_POSE", end) && reached("ICP_POSE", end); }, 60));
  }

  /// Of all inputs of the processes that work on every frame.
  void expect_nothing_lost(std::int64_t frames) {
    for (const std::string process : {"surf", "odometry", "fastslam", "icp"}) {
      SCOPED_TRACE(process);
      const std::string input = process == "odometry"   ? "ENCODERS"
                                : process == "fastslam" ? "FEATURES"
                                                        : "CAMERA";
      const auto all_in = [&](const status_t& s) {
        return std::any_of(s.inputs.begin(), s.inputs.end(), [&](const input_status_t& in) {
          return in.channel == input && in.received >= (process == "odometry" ? 1 : frames);
        });
      };
      EXPECT_TRUE(bus_.wait_for_status(process, all_in, 30));
      const auto status = bus_.status(process);
      ASSERT_TRUE(status);
      for (const input_status_t& in : status->inputs) {
        EXPECT_EQ(in.lost, 0) << in.channel;
        EXPECT_EQ(in.queue_drops, 0) << in.channel;
        EXPECT_EQ(in.decode_errors, 0) << in.channel;
      }
    }
  }

  void stop_and_check_maps() {
    ASSERT_TRUE(bus_.wait_for_status(
        "map-server",
        [](const status_t& s) { return value_of(s, "landmarks") > 0 && value_of(s, "map_points") > 0; }, 60));
    graph_->send(SIGINT);
    EXPECT_EQ(graph_->wait(60).exit_code, 0) << graph_->output();
    EXPECT_GT(load_ply(folder_ / "maps/fastslam_map.ply").size(), 100U);
    EXPECT_GT(load_ply(folder_ / "maps/icp_map.ply").size(), 5'000U);
  }

  TemporaryFolder folder_;
  Bus bus_;
  std::optional<Program> graph_;
};

TEST_F(Replay, ASimulatedLogGivesMaps) {
  const std::string log = folder_ / "run.lcmlog";
  const Result made = run(
      {"lcmslam", "simulate", source_folder() / "config/scenes/kitchen.yaml", log, "--seconds", "6"}, 120);
  ASSERT_EQ(made.exit_code, 0) << made.output;
  const LogFacts facts = read_log(log);
  EXPECT_NEAR(facts.events.at("CAMERA"), 60, 2);
  EXPECT_NEAR(facts.events.at("ENCODERS"), 300, 5);
  EXPECT_NEAR(facts.events.at("CAMERA_CALIBRATION"), 6, 1);
  EXPECT_NEAR(facts.events.at("GROUND_TRUTH"), 300, 5);

  start_graph();
  play(log);
  if (patience_factor == 1) expect_nothing_lost(facts.events.at("CAMERA"));  // a sanitizer is too slow for it
  stop_and_check_maps();
}

TEST_F(Replay, InStepWithTheMappersNothingIsDroppedAtFullSpeed) {
  const std::string log = source_folder() / "logs/kitchen.lcmlog";
  const int frames = read_log(log).events.at("CAMERA");
  ASSERT_EQ(frames, 40);
  start_graph();
  const Result played = run({"lcmslam", "log", "play", log, "--lockstep"}, 120);
  EXPECT_EQ(played.exit_code, 0) << played.output;
  expect_nothing_lost(frames);
  // The last frame may wait for a wheel reading that the log does not have.
  EXPECT_GE(bus_.count("FASTSLAM_POSE"), static_cast<std::size_t>(frames - 1)) << played.output;
  EXPECT_GE(bus_.count("ICP_POSE"), static_cast<std::size_t>(frames - 1)) << played.output;
  stop_and_check_maps();
}

// The receive buffer that a stock kernel grants is too small for VGA images with depth: they go in pieces.
TEST_F(Replay, BigImagesPassTheStockReceiveBuffer) {
  const std::string log = folder_ / "vga.lcmlog";
  const Result made = run({"lcmslam", "simulate", source_folder() / "config/scenes/kitchen.yaml", log,
                           "--head", "rgbd", "--seconds", "2"},
                          120);
  ASSERT_EQ(made.exit_code, 0) << made.output;
  const int frames = read_log(log).events.at("CAMERA");
  ASSERT_GT(frames, 50);
  const std::string stock_url = url().substr(0, url().find('?')) + "?ttl=0&recv_buf_size=212992";
  start_graph(stock_url);
  const Result played = run({"lcmslam", "log", "play", log, "--lockstep", "--lcm-url", stock_url}, 120);
  EXPECT_EQ(played.exit_code, 0) << played.output;
  EXPECT_GT(bus_.count("CAMERA_PART"), static_cast<std::size_t>(frames)) << played.output;
  EXPECT_EQ(bus_.count("CAMERA"), 0U) << played.output;
  expect_nothing_lost(frames);
  stop_and_check_maps();
}

TEST_F(Replay, CtrlCEndsAPlayerWithItsAccount) {
  Program player({"lcmslam", "log", "play", source_folder() / "logs/kitchen.lcmlog", "--loop"});
  ASSERT_TRUE(wait_until([&] { return player.wrote("plays CAMERA"); }, 30));
  player.send(SIGINT);
  EXPECT_EQ(player.wait(30).exit_code, 0) << player.output();
  EXPECT_TRUE(player.wrote("times real time")) << player.output();
}

TEST_F(Replay, DriversWithoutCalibrationAreMappedWithOneFromAFile) {
  const auto config = folder_ / "robot.yaml";
  std::ofstream(config) << "include: " << (source_folder() / "config/replay.yaml").string()
                        << "\nlaunch: {processes: [camera, surf, odometry, fastslam, icp, map-server]}\n"
                           "camera: {source: calibration, calibration: {file: head.yaml}}\n";
  std::ofstream(folder_ / "head.yaml")
      << "sensor: mine\ncolour: {width: 640, height: 480, fx: 554, fy: 554, cx: 319.5, cy: 239.5}\n"
         "depth: {width: 176, height: 144, fx: 200, fy: 200, cx: 87.5, cy: 71.5}\n"
         "colour_depth: {translation: [0.08, 0, 0], quaternion: [1, 0, 0, 0]}\n";
  const std::string log = folder_ / "drivers.lcmlog";
  ASSERT_EQ(run({"lcmslam", "log", "cut", source_folder() / "logs/kitchen.lcmlog", log, "--channels",
                 "CAMERA,ENCODERS"},
                60)
                .exit_code,
            0);
  start_graph(url(), config);
  ASSERT_TRUE(bus_.wait_for_status(
      "surf", [](const status_t& s) { return s.detail.find("waits for") == std::string::npos; }, 20));
  play(log);
  EXPECT_THAT(bus_.status("odometry")->detail, HasSubstr("source wheels, by what came first"));
  EXPECT_EQ(bus_.status("camera")->state, status_t::RUNNING);
  stop_and_check_maps();
}

TEST_F(Replay, CtrlCEndsBatchAndLeavesNoHalfLog) {
  const TemporaryFolder folder;
  Program batch({"lcmslam", "batch", source_folder() / "config/replay.yaml",
                 source_folder() / "logs/kitchen.lcmlog", "--out", folder.path()});
  ASSERT_TRUE(wait_until([&] { return !std::filesystem::is_empty(folder.path()); }, 30));
  batch.send(SIGINT);
  EXPECT_EQ(batch.wait(30).exit_code, 1) << batch.output();
  EXPECT_TRUE(batch.wrote("stopped by a signal")) << batch.output();
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST_F(Replay, CtrlCEndsAStudyAndWhatItRuns) {
  const TemporaryFolder folder;
  Program study({"lcmslam", "study", "--seeds", "1", "2"}, folder.path());
  ASSERT_TRUE(bus_.wait_for_status(
      "camera", [](const status_t&) { return true; }, 120))
      << study.output();
  const auto camera = static_cast<pid_t>(bus_.status("camera")->pid);
  study.send(SIGINT);
  EXPECT_EQ(study.wait(90).exit_code, 130) << study.output();
  EXPECT_TRUE(study.wrote("stopped by a signal")) << study.output();
  EXPECT_FALSE(process_exists(camera));
}

TEST_F(Replay, CtrlCEndsASimulationAndLeavesTheOldLog) {
  const TemporaryFolder folder;
  const auto log = folder / "old.lcmlog";
  std::ofstream(log) << "precious";
  Program simulate({"lcmslam", "simulate", source_folder() / "config/scenes/kitchen.yaml", log, "--force"});
  const auto files = [&] { return std::distance(std::filesystem::directory_iterator(folder.path()), {}); };
  ASSERT_TRUE(wait_until([&] { return files() == 2; }, 30)) << simulate.output();  // the part file
  simulate.send(SIGINT);
  EXPECT_EQ(simulate.wait(30).exit_code, 1) << simulate.output();
  EXPECT_TRUE(simulate.wrote("stopped by a signal: nothing is written")) << simulate.output();
  EXPECT_EQ(files(), 1);
  EXPECT_EQ(std::filesystem::file_size(log), 8U);
}

TEST_F(Replay, ASecondGraphDoesNotDisturbTheFirst) {
  start_graph();
  const Result launch =
      run({"lcmslam", "launch", source_folder() / "config/replay.yaml", "--out", folder_ / "second"}, 60);
  EXPECT_EQ(launch.exit_code, 2) << launch.output;
  EXPECT_THAT(launch.output, HasSubstr("runs here already"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "second")) << "what does not start leaves nothing";
  const Result demo =
      run({"lcmslam", "demo", "--headless", "--seconds", "1", "--out", folder_ / "demo"}, 200);
  EXPECT_THAT(demo.output, HasSubstr("runs here already"));
  EXPECT_THAT(demo.output,
              AllOf(HasSubstr("there is no live page"), HasSubstr("map view"), Not(HasSubstr("http:"))))
      << "no browser reaches its bus";
  EXPECT_FALSE(bus_.newest<pose_estimate_t>("ICP_POSE")) << "the demo's images came to the first graph";
}

TEST_F(Replay, WhatTheLoggerRecordsOfALiveRunGivesMaps) {
  const std::string log = folder_ / "live.lcmlog";
  Program logger({"lcm-logger", "--lcm-url=" + url(), "-c", raw_channels, log});
  ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(log) || !logger.running(); }, 20));
  ASSERT_TRUE(logger.running()) << logger.output();
  const Result demo =
      run({"lcmslam", "demo", "--headless", "--seconds", "5", "--out", folder_ / "demo"}, 200);
  ASSERT_EQ(demo.exit_code, 0) << demo.output;
  ASSERT_THAT(demo.output, Not(HasSubstr("private bus"))) << "the logger is not on it";
  logger.send(SIGINT);
  ASSERT_TRUE(logger.wait(20).ended) << logger.output();

  const LogFacts facts = read_log(log);
  ASSERT_THAT(facts.events, testing::SizeIs(4)) << "nothing but raw data";
  EXPECT_NEAR(facts.events.at("CAMERA"), 50, 3);
  start_graph();
  play(log);
  stop_and_check_maps();
}

}  // namespace
}  // namespace lcmslam::integration
