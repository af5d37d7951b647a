// A graph on two hosts: two network namespaces joined by a pair of virtual cards. The robot has camera and
// odometry, the base has the rest. Each host's launch starts its own share.

#include <gmock/gmock.h>

#include <csignal>
#include <cstdlib>
#include <fstream>

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
            (folder_ / host).string(), "--set",  "launch.interface=" + interface};
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

TEST_F(TwoHosts, ARouteThatWasLeftOnLoIsSaid) {
  ASSERT_TRUE(shell("ip route replace 224.0.0.0/4 dev lo"));
  const Result result = run(launch("robot", "wire0"), 60);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, testing::HasSubstr("meant to leave through wire0"));
  EXPECT_THAT(result.output, testing::HasSubstr("sudo ip route replace 239.255.76.67/32 dev wire0"));
}

}  // namespace
}  // namespace lcmslam::integration
