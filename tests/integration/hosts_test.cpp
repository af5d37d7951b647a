// A graph on two hosts: two network namespaces joined by a pair of virtual cards. The robot has camera and
// odometry, the base has the rest. Each host's launch starts its own share.

#include <gmock/gmock.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <map>

#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"

namespace lcmslam::integration {
namespace {

constexpr double patience = 120;  // s

bool shell(const std::string& line) {
  return std::system((line + " > /dev/null 2>&1").c_str()) == 0;
}

class TwoHosts : public testing::Test {
 protected:
  void SetUp() override {
    // This process is the robot; a sleeper in a namespace of its own is the base.
    base_.emplace(std::vector<std::string>{"/usr/bin/unshare", "-n", "sleep", "1000"});
    const std::string base = std::to_string(base_->pid());
    const auto in_own_namespace = [&] {
      std::error_code error;
      const auto theirs = std::filesystem::read_symlink("/proc/" + base + "/ns/net", error);
      return !error && theirs != std::filesystem::read_symlink("/proc/self/ns/net");
    };
    if (!wait_until(in_own_namespace, 5) ||
        !shell("ip link add wire0 type veth peer name wire1 netns " + base))
      GTEST_SKIP() << "this machine permits no second network namespace: two hosts are not tested";
    enter_ = "nsenter --net=/proc/" + base + "/ns/net ";
    ASSERT_TRUE(
        shell("ip addr add 10.77.0.1/24 dev wire0 && ip link set wire0 up && "
              "ip route replace 224.0.0.0/4 dev wire0"));
    ASSERT_TRUE(shell(enter_ + "ip addr add 10.77.0.2/24 dev wire1") &&
                shell(enter_ + "ip link set wire1 up") && shell(enter_ + "ip link set lo up") &&
                shell(enter_ + "ip route replace 224.0.0.0/4 dev wire1"));
    setenv("LCMSLAM_BUS_ALLOW", "10.77.0.0/24", 1);
    std::ofstream(folder_ / "graph.yaml")
        << "include: " << (source_folder() / "config/demo.yaml").string()
        << "\nlaunch:\n  host: base\n  ttl: 1\n  camera: {host: robot}\n  odometry: {host: robot}\n"
           "  fastslam: {after: [odometry]}\n";
  }
  void TearDown() override {
    unsetenv("LCMSLAM_BUS_ALLOW");
    shell("ip link del wire0; ip route replace 224.0.0.0/4 dev lo");
  }

  std::vector<std::string> launch(const std::string& host, const std::string& interface) {
    return {find_program("lcmslam"),   "launch", (folder_ / "graph.yaml").string(), "--host", host, "--out",
            (folder_ / host).string(), "--set",  "launch.interface=" + interface,   "--force"};
  }
  std::vector<std::string> on_base(std::vector<std::string> line) {
    line.insert(line.begin(),
                {"/usr/bin/nsenter", "--net=/proc/" + std::to_string(base_->pid()) + "/ns/net"});
    return line;
  }

  TemporaryFolder folder_;
  std::optional<Program> base_;
  std::string enter_;
};

TEST_F(TwoHosts, NothingIsLostBetweenThemAndTheirClocksAreCompared) {
  setenv("LCM_DEFAULT_URL", "udpm://239.255.76.67:7667?ttl=1&recv_buf_size=2097152", 1);
  Bus bus;
  Program base(on_base(launch("base", "wire1")));
  Program robot(launch("robot", "wire0"));
  const auto received = [](const status_t& s, const std::string& channel) {
    std::int64_t sum = 0;
    for (const auto& in : s.inputs) sum += in.channel == channel ? in.received : 0;
    return sum;
  };
  for (const std::string process : {"surf", "icp"})
    ASSERT_TRUE(bus.wait_for_status(
        process, [&](const status_t& s) { return received(s, "CAMERA") >= 100; }, patience))
        << process << "\n"
        << base.output() << robot.output();
  for (const std::string process : {"surf", "fastslam", "icp", "map-server"}) {
    const auto status = bus.status(process);
    ASSERT_TRUE(status) << process;
    for (const auto& in : status->inputs) EXPECT_EQ(in.lost, 0) << process << " <- " << in.channel;
    EXPECT_EQ(status->kernel_drops, 0) << process;
  }
  std::cout << "surf took " << received(*bus.status("surf"), "CAMERA") << " images of the other host, icp "
            << received(*bus.status("icp"), "CAMERA") << "\n";
  EXPECT_TRUE(wait_until([&] { return robot.wrote("base's clock: "); }, patience)) << robot.output();
  EXPECT_TRUE(wait_until([&] { return robot.wrote("surf on base: running"); }, patience)) << robot.output();
  EXPECT_FALSE(robot.wrote("do not fit together")) << robot.output();
  for (Program* program : {&robot, &base}) program->send(SIGINT);
  EXPECT_EQ(robot.wait(60).exit_code, 0) << robot.output();
  EXPECT_EQ(base.wait(60).exit_code, 0) << base.output();
}

// First the cable, then the whole robot: its launch is killed, and its processes die with it.
TEST_F(TwoHosts, ALostHostIsToldWithinASecondAndMappingGoesOnWhenItReturns) {
  setenv("LCM_DEFAULT_URL", "udpm://239.255.76.67:7667?ttl=1&recv_buf_size=2097152", 1);
  Bus bus;
  Program base(on_base(launch("base", "wire1")));
  std::optional<Program> robot(launch("robot", "wire0"));
  const auto poses = [&] { return std::min(bus.count("FASTSLAM_POSE"), bus.count("ICP_POSE")); };
  ASSERT_TRUE(wait_until([&] { return poses() > 50; }, patience)) << base.output() << robot->output();
  const auto pid = [&](const std::string& process) { return bus.status(process)->pid; };
  const std::vector<std::string> mappers = {"surf", "fastslam", "icp", "map-server"};
  std::map<std::string, std::int64_t> pids;
  for (const std::string& process : mappers) pids[process] = pid(process);
  const auto seconds_until = [&](const std::function<bool()>& happens) {
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_TRUE(wait_until(happens, patience)) << base.output() << robot->output();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const auto more_poses = [&] { return [&, before = poses()] { return poses() > before + 10; }; };

  ASSERT_TRUE(shell(enter_ + "ip link set wire1 down"));
  const double base_told = seconds_until([&] { return base.wrote("robot is lost"); });
  const double robot_told = base_told + seconds_until([&] { return robot->wrote("base is lost"); });
  ASSERT_TRUE(shell(enter_ + "ip link set wire1 up") &&
              shell(enter_ + "ip route replace 224.0.0.0/4 dev wire1"));
  const double heard = seconds_until([&] { return base.wrote("robot is heard again"); });
  const double mapped = heard + seconds_until(more_poses());
  EXPECT_THAT(pids, testing::Each(testing::ResultOf([&](const auto& p) { return pid(p.first) == p.second; },
                                                    testing::IsTrue())));

  const auto wrote_twice = [&](const std::string& text) {
    const std::string output = base.output();
    return output.find(text, output.find(text) + 1) != std::string::npos;
  };
  robot->send(SIGKILL);
  const double dead_told = seconds_until([&] { return wrote_twice("robot is lost"); });
  robot->wait(60);
  robot.emplace(launch("robot", "wire0"));
  seconds_until([&] { return wrote_twice("robot is heard again"); });
  const double restarted = seconds_until(more_poses());
  std::cout << "a cut cable is told by base after " << base_told << " s, by the robot after " << robot_told
            << " s; mended, the robot is heard again after " << heard << " s and mapped on after " << mapped
            << " s; a dead robot is told after " << dead_told << " s, mapped on " << restarted
            << " s after its launch is heard again\n";
  EXPECT_LT(base_told, 1);
  EXPECT_LT(robot_told, 1.1);
  EXPECT_LT(dead_told, 1);
}

TEST_F(TwoHosts, ARouteThatWasLeftOnLoIsSaid) {
  ASSERT_TRUE(shell("ip route replace 224.0.0.0/4 dev lo"));
  const Result result = run(launch("robot", "wire0"), 60);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, testing::HasSubstr("meant to leave through wire0"));
  EXPECT_THAT(result.output, testing::HasSubstr("sudo ip route replace 239.255.76.67/32 dev wire0"));
}

}  // namespace
}  // namespace lcmslam::integration
