// Datagrams that kill whoever receives with LCM 1.3.1: sent to a running graph, by this machine and by
// another.

#include <gmock/gmock.h>

#include <csignal>
#include <fstream>

#include <lcmslam/command_t.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/udpm/multicast_address.hpp>
#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"
#include "tests/support/neighbour.hpp"

namespace lcmslam::integration {
namespace {

using lcmslam::testing::bytes_of;
using lcmslam::testing::killing_datagrams;
using lcmslam::testing::Neighbour;
using lcmslam::testing::UdpSender;
using lcmslam::testing::whole_datagram;

class Strangers : public ::testing::Test {
 protected:
  void launch() {
    launch_.emplace(std::vector<std::string>{"lcmslam", "launch", source_folder() / "config/demo.yaml",
                                             "--out", folder_.path()});
    for (const auto& name : process_names())
      ASSERT_TRUE(bus_->wait_for_status(name, is_up, 120)) << name << "\n" << launch_->output();
    for (const auto& name : process_names()) pids_[name] = bus_->status(name)->pid;
  }

  static bool is_up(const status_t& s) {
    return s.state == status_t::RUNNING || s.state == status_t::FINISHED;
  }

  /// All processes report twice more, under the same pid, and accept the last report.
  void expect_all_go_on(const std::function<bool(const status_t&)>& accepts) {
    std::map<std::string, std::size_t> reports;
    for (const auto& [name, pid] : pids_) reports[name] = bus_->status_count(name, pid);
    for (const auto& [name, pid] : pids_)
      EXPECT_TRUE(wait_until(
          [&, n = name, p = pid] {
            return bus_->status_count(n, p) > reports[n] + 1 && accepts(*bus_->status(n));
          },
          30))
          << name << "\n"
          << launch_->output();
    ASSERT_TRUE(launch_->running()) << "signal " << launch_->wait(0).signal << "\n" << launch_->output();
    EXPECT_FALSE(launch_->wrote(" ended: ")) << launch_->output();
  }

  void expect_clean_stop() {
    launch_->send(SIGINT);
    EXPECT_EQ(launch_->wait(60).exit_code, 0) << launch_->output();
  }

  const MulticastAddress address_ = multicast_address(lcm_url_from_environment());
  TemporaryFolder folder_;
  std::optional<Bus> bus_;
  std::optional<Program> launch_;
  std::map<std::string, std::int64_t> pids_;
};

TEST_F(Strangers, KillingDatagramsHarmNobodyAndAreCounted) {
  bus_.emplace();
  launch();
  Program spy({"lcmslam", "spy", "--once", "--json", "--seconds", "600"});
  ASSERT_TRUE(wait_until([&] { return spy.wrote("listens to ") || !spy.running(); }, 30)) << spy.output();
  const UdpSender stranger;
  for (const char* channel : {"CAMERA", "STATUS", "FEATURES", "ODOMETRY", "COMMAND"})
    for (const Bytes& datagram : killing_datagrams(channel))
      stranger.send(address_.group, address_.port, datagram);
  stranger.send(address_.group, address_.port, bytes_of("no datagram of LCM"));
  expect_all_go_on([](const status_t& s) { return value_of(s, "bus_malformed") >= 6; });

  spy.send(SIGINT);
  EXPECT_EQ(spy.wait(30).exit_code, 0) << spy.output();
  EXPECT_TRUE(spy.wrote("\"refused_malformed\":6")) << spy.output();
  EXPECT_THAT(run({"lcmslam", "doctor", "--seconds", "0.3"}, 60).output,
              ::testing::HasSubstr("refused 6 since its start"));
  expect_clean_stop();
}

TEST_F(Strangers, AnotherMachineReachesNothing) {
  auto neighbour = Neighbour::join();
  if (!neighbour) GTEST_SKIP() << "this machine permits no second network namespace";
  bus_.emplace();
  launch();
  command_t stop;
  stop.utime = 1;
  stop.name = "stop";
  stop.n = 0;
  std::vector<Bytes> datagrams = killing_datagrams("STATUS");
  datagrams.push_back(whole_datagram("COMMAND", encode_message(stop)));
  for (const Bytes& datagram : datagrams)
    for (const std::string to : {Neighbour::own_address, address_.group.c_str()})
      neighbour->send(to, address_.port, datagram);
  // Unicast reaches one of the sockets of the port, multicast all of them.
  expect_all_go_on([](const status_t& s) { return value_of(s, "bus_foreign") >= 3; });
  expect_clean_stop();
}

}  // namespace
}  // namespace lcmslam::integration
