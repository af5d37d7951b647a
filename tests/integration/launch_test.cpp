// `lcmslam launch` from another terminal, and who waits for whom.

#include <gmock/gmock.h>

#include <csignal>
#include <fstream>

#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"

namespace lcmslam::integration {
namespace {

constexpr double patience = 60;  // s

class Launch : public testing::Test {
 protected:
  void SetUp() override { setenv("XDG_RUNTIME_DIR", folder_.path().c_str(), 1); }
  void TearDown() override { unsetenv("XDG_RUNTIME_DIR"); }

  void launch(const std::string& section) {
    std::ofstream(folder_ / "graph.yaml") << "launch:\n" << section;
    launch_.emplace(std::vector<std::string>{"lcmslam", "launch", folder_ / "graph.yaml", "--out",
                                             (folder_ / "run").string()});
  }
  bool runs(const std::string& process) {
    return bus_.wait_for_status(
        process, [](const status_t& s) { return s.state == status_t::RUNNING; }, patience);
  }
  Result ask(std::vector<std::string> words) {
    words.insert(words.begin(), {"lcmslam", "launch"});
    return run(words, patience);
  }

  TemporaryFolder folder_;
  Bus bus_;
  std::optional<Program> launch_;
};

TEST_F(Launch, IsAskedToldAndStoppedFromAnotherTerminal) {
  EXPECT_EQ(ask({"--status"}).exit_code, 3) << "none runs";
  launch("  processes: [odometry, fastslam]\n  fastslam: {after: [odometry]}\n");
  ASSERT_TRUE(runs("odometry") && runs("fastslam")) << launch_->output();
  const std::string begin = launch_->output();
  EXPECT_THAT(begin, testing::HasSubstr("fastslam starts")) << "it waited";

  EXPECT_TRUE(wait_until(
      [&] {
        const std::string table = ask({"--status"}).output;
        return table.find("odometry") != std::string::npos && table.find("starting") == std::string::npos;
      },
      patience));
  const auto before = bus_.status("odometry")->pid;
  EXPECT_EQ(ask({"--restart", "odometry"}).exit_code, 0);
  EXPECT_TRUE(bus_.wait_for_status(
      "odometry", [&](const status_t& s) { return s.pid != before; }, patience));
  const Result wrong = ask({"--restart", "camera"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.output, testing::HasSubstr("odometry fastslam"));

  EXPECT_EQ(ask({"--stop"}).exit_code, 0);
  EXPECT_EQ(launch_->wait(patience).exit_code, 0) << launch_->output();
  EXPECT_EQ(ask({"--stop"}).exit_code, 3);
}

TEST_F(Launch, WhatNeverBecomesReadyIsWaitedForAndSaid) {
  launch(
      "  processes: [odometry, camera]\n  host: here\n  ttl: 1\n  camera: {host: there}\n  odometry: {after: "
      "[camera]}\n");
  EXPECT_EQ(launch_->wait(patience).exit_code, 2) << "this host has another name";
  EXPECT_TRUE(launch_->wrote("launch --host NAME")) << launch_->output();
  launch_.emplace(std::vector<std::string>{"lcmslam", "launch", folder_ / "graph.yaml", "--host", "here",
                                           "--out", (folder_ / "run").string()});
  EXPECT_TRUE(wait_until(
      [&] { return ask({"--status"}).output.find("odometry waits for camera") != std::string::npos; },
      patience))
      << launch_->output();
  EXPECT_THAT(ask({"--status"}).output, testing::HasSubstr("camera on there: not heard yet"));
  EXPECT_EQ(ask({"--stop"}).exit_code, 0);
}

TEST_F(Launch, GivesUpWithTheFirstCauseOnItsLastLine) {
  // Without memory it cannot even begin, again and again.
  launch("  processes: [odometry]\n  restart_limit: 1\n  odometry: {memory: 1}\n");
  EXPECT_EQ(launch_->wait(patience).exit_code, 1) << launch_->output();
  EXPECT_TRUE(launch_->wrote("stays away after 1 restarts in a row")) << launch_->output();
  EXPECT_TRUE(launch_->wrote("not all went well, first: odometry was not running any more"))
      << launch_->output();
}

}  // namespace
}  // namespace lcmslam::integration
