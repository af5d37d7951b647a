// What `lcmslam launch` does when its processes die, when it is asked to stop, and when it is killed.

#include <gmock/gmock.h>

#include <fmt/format.h>
#include <algorithm>
#include <csignal>
#include <iostream>
#include <set>
#include <thread>

#include <lcmslam/runtime/options.hpp>
#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"

namespace lcmslam::integration {
namespace {

constexpr double start_patience = 120;  // s
constexpr double stop_patience = 60;    // s; launch itself waits 20 s for INT, then 5 s for TERM

class Resilience : public testing::Test {
 protected:
  void launch() {
    launch_.emplace(std::vector<std::string>{"lcmslam", "launch", source_folder() / "config/demo.yaml",
                                             "--out", folder_.path(), "--set",
                                             "map-server.folder=" + (folder_ / "maps").string()});
  }

  /// Every process reports and both mappers publish.
  void wait_for_mapping() {
    for (const auto& name : process_names())
      ASSERT_TRUE(bus_.wait_for_status(name, is_up, start_patience)) << name << "\n" << launch_->output();
    ASSERT_TRUE(wait_until([&] { return bus_.count("FASTSLAM_POSE") > 3 && bus_.count("ICP_POSE") > 3; },
                           start_patience))
        << launch_->output();
  }

  static bool is_up(const status_t& s) {
    return s.state == status_t::RUNNING || s.state == status_t::FINISHED;
  }

  std::int64_t pid_of(const std::string& process) const { return bus_.status(process)->pid; }

  std::map<std::string, std::int64_t> pids() const {
    std::map<std::string, std::int64_t> result;
    for (const auto& name : process_names()) result[name] = pid_of(name);
    return result;
  }

  static std::vector<std::string> alive(const std::map<std::string, std::int64_t>& processes) {
    std::vector<std::string> names;
    for (const auto& [name, pid] : processes)
      if (process_exists(static_cast<pid_t>(pid))) names.push_back(name);
    return names;
  }

  /// Kills one process; the others must go on as they are and it must come back.
  void kill_and_expect_return(const std::string& victim) {
    SCOPED_TRACE(victim);
    const auto before = pids();
    std::map<std::string, std::size_t> reports;
    for (const auto& [name, pid] : before) reports[name] = bus_.status_count(name, pid);
    const std::size_t endings = occurrences(victim + " ended: signal 9");

    ASSERT_EQ(kill(static_cast<pid_t>(before.at(victim)), SIGKILL), 0);
    EXPECT_TRUE(wait_until([&] { return occurrences(victim + " ended: signal 9") > endings; }, 20))
        << launch_->output();
    EXPECT_TRUE(bus_.wait_for_status(
        victim, [&](const status_t& s) { return s.pid != before.at(victim) && is_up(s); }, start_patience))
        << launch_->output();
    for (const auto& [name, pid] : before) {
      if (name == victim) continue;
      EXPECT_TRUE(wait_until([&, n = name, p = pid] { return bus_.status_count(n, p) > reports[n] + 1; }, 20))
          << name << " fell silent";
      EXPECT_EQ(pid_of(name), pid) << name << " did not survive";
    }
  }

  /// s, the longest time without a new message on the channel, of the next `seconds`.
  double silence(const std::string& channel, double seconds) const {
    using Clock = std::chrono::steady_clock;
    const auto since = [](Clock::time_point time) {
      return std::chrono::duration<double>(Clock::now() - time).count();
    };
    const auto begin = Clock::now();
    auto last = begin;
    double longest = 0;
    std::size_t count = bus_.count(channel);
    while (since(begin) < seconds) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      longest = std::max(longest, since(last));
      if (bus_.count(channel) == count) continue;
      count = bus_.count(channel);
      last = Clock::now();
    }
    return longest;
  }

  std::size_t occurrences(const std::string& text) const {
    const std::string output = launch_->output();
    std::size_t n = 0;
    for (std::size_t at = output.find(text); at != std::string::npos; at = output.find(text, at + 1)) ++n;
    return n;
  }

  TemporaryFolder folder_;
  Bus bus_;
  std::optional<Program> launch_;
};

TEST_F(Resilience, AKilledProcessComesBackAndTheOthersGoOn) {
  launch();
  wait_for_mapping();
  for (const auto& name : process_names()) kill_and_expect_return(name);

  // The graph of processes old and new still maps.
  const std::size_t fastslam = bus_.count("FASTSLAM_POSE");
  const std::size_t icp = bus_.count("ICP_POSE");
  EXPECT_TRUE(
      wait_until([&] { return bus_.count("FASTSLAM_POSE") > fastslam && bus_.count("ICP_POSE") > icp; }, 60));

  const auto processes = pids();
  launch_->send(SIGINT);
  const Ending ending = launch_->wait(stop_patience);
  EXPECT_TRUE(ending.ended) << launch_->output();
  EXPECT_EQ(ending.exit_code, 0) << launch_->output();
  EXPECT_THAT(alive(processes), testing::IsEmpty());
}

// Killed again soon after, too: a process that has not run for long is back as fast.
TEST_F(Resilience, AKillCostsLessThanASecondOfPoses) {
  launch();
  wait_for_mapping();
  ASSERT_TRUE(wait_until([&] { return bus_.count("FASTSLAM_POSE") > 100; }, 60));
  std::cout << fmt::format("undisturbed: {:.2f} and {:.2f} s\n", silence("FASTSLAM_POSE", 2),
                           silence("ICP_POSE", 2));
  for (int round = 0; round < 2; ++round)
    for (const auto& [victim, channel] : {std::pair("surf", "FASTSLAM_POSE"),
                                          {"icp", "ICP_POSE"},
                                          {"fastslam", "FASTSLAM_POSE"},
                                          {"odometry", "ICP_POSE"}}) {
      ASSERT_EQ(kill(static_cast<pid_t>(pid_of(victim)), SIGKILL), 0);
      const double missed = silence(channel, 2);
      std::cout << fmt::format("{} is killed: no {} for {:.2f} s\n", victim, channel, missed);
      EXPECT_LT(missed, 1 * patience_factor) << victim << " " << round;
    }
  launch_->send(SIGINT);
  EXPECT_EQ(launch_->wait(stop_patience).exit_code, 0) << launch_->output();
}

TEST_F(Resilience, CtrlCStopsAllAndSavesTheMaps) {
  launch();
  wait_for_mapping();
  ASSERT_TRUE(bus_.wait_for_status(
      "map-server",
      [](const status_t& s) { return value_of(s, "landmarks") > 0 && value_of(s, "map_points") > 0; }, 60));
  const auto processes = pids();
  launch_->send(SIGINT);
  const Ending ending = launch_->wait(stop_patience);
  EXPECT_EQ(ending.exit_code, 0) << launch_->output();
  EXPECT_THAT(alive(processes), testing::IsEmpty());
  for (const std::string file : {"fastslam_map.ply", "fastslam_map.pcd", "icp_map.ply", "icp_map.pcd"})
    EXPECT_TRUE(std::filesystem::exists(folder_ / "maps" / file)) << file;
}

TEST_F(Resilience, KillingLaunchLeavesNoOrphan) {
  launch();
  wait_for_mapping();
  const auto processes = pids();
  EXPECT_EQ(alive(processes).size(), process_names().size());
  launch_->send(SIGKILL);
  EXPECT_EQ(launch_->wait(20).signal, SIGKILL);
  EXPECT_TRUE(wait_until([&] { return alive(processes).empty(); }, stop_patience))
      << "orphans: " << testing::PrintToString(alive(processes));
}

}  // namespace
}  // namespace lcmslam::integration
