// What stays on the disk of a run, and what its exit code says, when processes are killed, commands come from
// strangers and files cannot be written.

#include <gmock/gmock.h>

#include <csignal>

#include <lcmslam/command_t.hpp>
#include <lcmslam/map_store/file/check_map_file.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"

namespace lcmslam::integration {
namespace {

using testing::HasSubstr;

constexpr double start_patience = 120;  // s
constexpr double stop_patience = 60;    // s

class RunFiles : public testing::Test {
 protected:
  /// In the shell: `before` may limit what the graph can do.
  void launch(const std::string& before = "", const std::vector<std::string>& overrides = {}) {
    std::string command = before + "exec '" + find_program("lcmslam") + "' launch '" +
                          (source_folder() / "config/demo.yaml").string() + "' --out '" +
                          folder_.path().string() + "'";
    for (const auto& value : overrides) command += " --set " + value;
    launch_.emplace(std::vector<std::string>{"/bin/sh", "-c", command});
  }

  void wait_for_maps() {
    ASSERT_TRUE(bus_.wait_for_status(
        "map-server",
        [](const status_t& s) {
          return value_of(s, "landmarks") > 100 && value_of(s, "map_points") > 10'000;
        },
        start_patience))
        << launch_->output();
  }

  std::string last_line() const {
    const std::string text = launch_->output();
    const std::size_t end = text.find_last_not_of('\n');
    return text.substr(text.rfind('\n', end) + 1, end - text.rfind('\n', end));
  }

  /// A COMMAND with the confirmation of these processes.
  command_t command(const std::string& name, const std::vector<std::string>& confirmed = {}) {
    command_t c;
    c.utime = 0;
    c.seq = commands_++;
    c.sender = 99;
    c.name = name;
    for (const auto& process : confirmed) {
      c.keys.push_back(process);
      c.values.push_back(std::to_string(bus_.status(process)->sender));
    }
    c.n = static_cast<std::int32_t>(c.keys.size());
    return c;
  }

  TemporaryFolder folder_;
  Bus bus_;
  std::optional<Program> launch_;
  std::int64_t commands_ = 0;
};

TEST_F(RunFiles, WhatWasMappedSurvivesTheDeathOfAll) {
  launch("", {"map-server.snapshot_period=0.5"});
  wait_for_maps();
  ASSERT_TRUE(bus_.wait_for_status(
      "map-server", [](const status_t& s) { return value_of(s, "saved") >= 2; }, 30));
  std::vector<std::int64_t> pids;
  for (const auto& name : process_names()) pids.push_back(bus_.status(name)->pid);
  launch_->send(SIGKILL);
  for (const std::int64_t pid : pids) kill(static_cast<pid_t>(pid), SIGKILL);
  EXPECT_EQ(launch_->wait(20).signal, SIGKILL);
  EXPECT_GT(load_ply(folder_ / "fastslam_map.ply").size(), 50U);
  EXPECT_GT(load_pcd(folder_ / "icp_map.pcd").size(), 5'000U);
  const MapFileCheck store = check_map_file(folder_ / "map.lcmslam");
  EXPECT_THAT(store.faults, testing::IsEmpty());
  EXPECT_GT(store.landmarks, 50);
  EXPECT_GT(store.clouds, 0);
  EXPECT_GT(store.features, 0);
  EXPECT_GT(store.poses, 10);
}

TEST_F(RunFiles, MapsThatCannotBeSavedAreTheExitCodeAndTheLastLine) {
  launch("trap '' XFSZ; ulimit -f 100; ");  // 50 kB a file
  wait_for_maps();
  launch_->send(SIGINT);
  EXPECT_EQ(launch_->wait(stop_patience).exit_code, 1) << launch_->output();
  EXPECT_THAT(last_line(), testing::AllOf(HasSubstr("map-server"), HasSubstr("maps are not saved"),
                                          HasSubstr("_map.p"), HasSubstr("File too large")));
}

TEST_F(RunFiles, ATerminalThatIsClosedIsNoLossOfTheMaps) {
  launch();
  wait_for_maps();
  launch_->send(SIGHUP);
  EXPECT_EQ(launch_->wait(stop_patience).exit_code, 0) << launch_->output();
  EXPECT_THAT(last_line(), HasSubstr("all is saved in " + folder_.path().string()));
}

TEST_F(RunFiles, StrangersNeitherStopProcessesNorResetMaps) {
  launch();
  wait_for_maps();
  std::map<std::string, std::int64_t> before;
  for (const auto& name : process_names()) before[name] = bus_.status(name)->pid;
  const double landmarks = value_of(*bus_.status("map-server"), "landmarks");
  bus_.publish("COMMAND", command("stop"));
  bus_.publish("COMMAND", command("reset"));
  for (const auto& [name, pid] : before) {
    EXPECT_TRUE(bus_.wait_for_status(
        name, [&, p = pid](const status_t& s) { return s.pid == p && value_of(s, "commands_refused") == 2; },
        20))
        << name;
  }
  EXPECT_GE(value_of(*bus_.status("map-server"), "landmarks"), 0.5 * landmarks);

  bus_.publish("COMMAND", command("reset", {"icp", "fastslam"}));
  EXPECT_TRUE(wait_until([&] { return std::filesystem::exists(folder_ / "before-reset-1/icp_map.pcd"); }, 20))
      << launch_->output();
  EXPECT_GT(load_ply(folder_ / "before-reset-1/icp_map.ply").size(), 5'000U);
  bus_.publish("COMMAND", command("stop", {"surf"}));
  EXPECT_TRUE(wait_until([&] { return launch_->wrote("surf ended: exit 0"); }, 20)) << launch_->output();
  launch_->send(SIGINT);
  EXPECT_EQ(launch_->wait(stop_patience).exit_code, 0) << launch_->output();
  EXPECT_FALSE(launch_->wrote("surf restarted"));
  EXPECT_THAT(last_line(), HasSubstr("all is saved in " + folder_.path().string()));
}

TEST_F(RunFiles, AFolderWithAnyNameTakesTheMaps) {
  const auto folder = folder_ / "a run\n#2: \"x\"";
  const Result batch = run({"lcmslam", "batch", source_folder() / "config/replay.yaml",
                            source_folder() / "logs/kitchen.lcmlog", "--to", "0.5", "--out", folder},
                           120);
  EXPECT_EQ(batch.exit_code, 0) << batch.output;
  EXPECT_TRUE(std::filesystem::exists(folder / "icp_map.ply"));
}

TEST_F(RunFiles, ABatchThatWasKilledLeavesNothingToTheNextOne) {
  const std::vector<std::string> arguments = {"lcmslam",
                                              "batch",
                                              source_folder() / "config/replay.yaml",
                                              source_folder() / "logs/kitchen.lcmlog",
                                              "--to",
                                              "0.5",
                                              "--out",
                                              folder_.path()};
  {
    Program batch(arguments);
    ASSERT_TRUE(wait_until([&] { return !std::filesystem::is_empty(folder_.path()); }, 30));
  }  // killed here
  EXPECT_FALSE(std::filesystem::is_empty(folder_.path())) << "a part file stays";
  EXPECT_EQ(run(arguments, 120).exit_code, 0);
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    EXPECT_EQ(entry.path().filename().string().find(".part"), std::string::npos) << entry.path();
}

}  // namespace
}  // namespace lcmslam::integration
