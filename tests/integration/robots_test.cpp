// Two robots' graphs on one bus.

#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <set>

#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"

namespace lcmslam::integration {
namespace {

constexpr double patience = 120;  // s

class TwoRobots : public testing::Test {
 protected:
  std::unique_ptr<Program> launch(const std::string& robot) {
    const auto file = folder_ / (robot + ".yaml");
    std::ofstream(file) << "include: " << (source_folder() / "config/demo.yaml").string()
                        << "\nlaunch: {processes: [camera, surf, odometry], robot: " << robot
                        << "}\ncamera: {wait_for: [surf, odometry]}\n";
    return std::make_unique<Program>(
        std::vector<std::string>{"lcmslam", "launch", file, "--out", (folder_ / robot).string()});
  }
  std::optional<status_t> status(const std::string& robot, const std::string& process) {
    const auto newest = bus_.newest<status_t>(robot + "/STATUS");
    if (newest && newest->process == process) statuses_[robot + process] = *newest;
    const auto found = statuses_.find(robot + process);
    if (found == statuses_.end()) return std::nullopt;
    return found->second;
  }

  TemporaryFolder folder_;
  Bus bus_;
  std::map<std::string, status_t> statuses_;
};

TEST_F(TwoRobots, HearThemselvesAlone) {
  const auto dora = launch("dora"), ed = launch("ed");
  for (const std::string robot : {"dora", "ed"})
    ASSERT_TRUE(wait_until(
        [&] {
          const auto surf = status(robot, "surf");
          const auto it = surf ? surf->inputs : std::vector<input_status_t>{};
          return std::any_of(it.begin(), it.end(),
                             [](const auto& in) { return in.channel == "CAMERA" && in.received > 20; });
        },
        patience))
        << robot << dora->output() << ed->output();
  EXPECT_EQ(bus_.count("CAMERA"), 0U);
  EXPECT_GT(bus_.count("dora/FEATURES"), 0U);
  EXPECT_GT(bus_.count("ed/ODOMETRY"), 0U);
  for (const std::string robot : {"dora", "ed"}) {
    std::set<std::int64_t> senders;
    const auto surf = status(robot, "surf");
    ASSERT_TRUE(surf);
    for (const auto& in : surf->inputs) {
      if (in.channel == "CAMERA") senders.insert(in.sender);
      EXPECT_EQ(in.lost, 0) << robot << " " << in.channel;
    }
    EXPECT_EQ(senders.size(), 1U) << robot << " hears two cameras";
  }
  // Tools: all of the bus, or one robot's channels by their plain names.
  const std::string all = run({"lcmslam", "spy", "--once"}, 30).output;
  EXPECT_THAT(all, testing::HasSubstr("dora/CAMERA"));
  EXPECT_THAT(all, testing::HasSubstr("ed/CAMERA"));
  setenv("LCMSLAM_ROBOT", "ed", 1);
  const std::string eds = run({"lcmslam", "spy", "--once"}, 30).output;
  unsetenv("LCMSLAM_ROBOT");
  EXPECT_THAT(eds, testing::Not(testing::HasSubstr("dora")));
  EXPECT_THAT(eds, testing::HasSubstr("CAMERA"));
  // A log of both becomes an ordinary one of each.
  const std::string log = (folder_ / "both.lcmlog").string();
  Program logger({"lcm-logger", "--lcm-url=" + std::string(std::getenv("LCM_DEFAULT_URL")), log});
  const std::size_t before = bus_.count("ed/FEATURES"), others = bus_.count("dora/FEATURES");
  ASSERT_TRUE(wait_until(
      [&] { return bus_.count("ed/FEATURES") > before + 10 && bus_.count("dora/FEATURES") > others + 10; },
      patience));
  logger.send(SIGINT);
  logger.wait(20);
  const std::string own = (folder_ / "ed.lcmlog").string();
  EXPECT_EQ(run({"lcmslam", "log", "cut", log, own, "--robot", "ed"}, 60).exit_code, 0);
  const std::string info = run({"lcmslam", "log", "info", own}, 60).output;
  EXPECT_THAT(info, testing::HasSubstr("FEATURES"));
  EXPECT_THAT(info, testing::Not(testing::HasSubstr("ed/")));
  EXPECT_THAT(info, testing::Not(testing::HasSubstr("dora/")));
  // Each launch is asked apart from the other.
  const Result which = run({"lcmslam", "launch", "--status"}, 30);
  EXPECT_EQ(which.exit_code, 2) << which.output;
  EXPECT_EQ(run({"lcmslam", "launch", "--stop", "--robot", "ed"}, 60).exit_code, 0);
  EXPECT_EQ(ed->wait(60).exit_code, 0) << ed->output();
  EXPECT_TRUE(dora->running());
  dora->send(SIGINT);
  EXPECT_EQ(dora->wait(60).exit_code, 0) << dora->output();
}

}  // namespace
}  // namespace lcmslam::integration
