// How soon a process says that something is wrong, and that it is right again: a disk that is full, a broker
// that dies, a camera that gives nothing more, strangers on the bus. The times are printed.

#include <gmock/gmock.h>

#include <fmt/format.h>
#include <sys/resource.h>
#include <cmath>
#include <fstream>

#include <lcmslam/map_request_t.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/udpm/multicast_address.hpp>
#include <lcmslam/twist_t.hpp>
#include "tests/integration/support/bridge_ends.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"
#include "tests/support/datagrams.hpp"
#include "tests/support/web_client.hpp"
#include "tests/support/written_head.hpp"

namespace lcmslam::integration {
namespace {

using ::testing::HasSubstr;

constexpr double patience = 30;  // s
constexpr double soon = 1;       // s: what a robot's operator was promised

class Detection : public ::testing::Test {
 protected:
  /// One process alone, in the shell after `before`.
  void start(const std::string& process, const std::string& settings, const std::string& before = "") {
    process_ = process;
    const std::string file = folder_ / (process + ".yaml");
    std::ofstream(file) << process << ":\n" << settings;
    program_.emplace(std::vector<std::string>{
        "/bin/sh", "-c",
        before + "exec '" + find_program("lcmslam-" + process) + "' --config '" + file + "'"});
  }

  /// s until a STATUS that the predicate accepts, while `meanwhile` is done each 20 ms.
  double told_after(
      const std::function<bool(const status_t&)>& accepts, const std::function<void()>& meanwhile = [] {}) {
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_TRUE(wait_until(
        [&] {
          meanwhile();
          const auto status = bus_.status(process_);
          return status && accepts(*status);
        },
        patience))
        << program_->output();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  /// us, of a report that has just come: the next one is due in a second.
  Utime reported(const std::function<void()>& meanwhile = [] {}) {
    const auto before = bus_.status(process_);
    told_after([&](const status_t& s) { return s.utime != before->utime; }, meanwhile);
    return bus_.status(process_)->utime;
  }
  /// What its words say is told at once, and not only when a report is due.
  void expect_told_early(Utime reported) {
    EXPECT_LT(1e-6 * static_cast<double>(bus_.status(process_)->utime - reported), soon * patience_factor);
  }

  /// What only raises a counter is told soon though it comes when a report has just gone out: the next one of
  /// itself is due in a second.
  void expect_told_soon(
      const std::string& what, const std::function<void()>& send,
      const std::function<double(const status_t&)>& count, const std::function<void()>& meanwhile = [] {}) {
    SCOPED_TRACE(what);
    const Utime last = reported(meanwhile);
    const double before = count(*bus_.status(process_));
    send();
    const double told = told_after([&](const status_t& s) { return count(s) > before; }, meanwhile);
    const double early = 1e-6 * static_cast<double>(bus_.status(process_)->utime - last);
    std::cout << fmt::format("{}: told after {:.2f} s\n", what, told);
    EXPECT_LT(told, 0.6 * soon * patience_factor);
    EXPECT_LT(early, 0.8 * soon * patience_factor);
  }
  /// 0 as long as nothing is told of it.
  static std::function<double(const status_t&)> value(const std::string& name) {
    return [name](const status_t& s) {
      const double counted = value_of(s, name);
      return std::isnan(counted) ? 0 : counted;
    };
  }

  static void print(const std::string& fault, double told, double recovered) {
    std::cout << fmt::format("{}: told after {:.2f} s, right again after {:.2f} s\n", fault, told, recovered);
  }

  TemporaryFolder folder_;
  Bus bus_;
  std::string process_;
  std::optional<Program> program_;
};

// What would make a file grow fails, as on a disk that is full, from one moment on to another.
TEST_F(Detection, AFullDisk) {
  start("map-server", "  folder: '" + folder_.path().string() + "'\n", "trap '' XFSZ; ");
  pose_estimate_t pose{};
  pose.sender = 77;
  pose.frame = "map";
  pose.child_frame = "robot";
  pose.status = pose_estimate_t::TRACKING;
  pose.T_map_robot.quat[0] = 1;
  const auto drive = [&] {
    pose.utime = wall_clock();
    ++pose.seq;
    bus_.publish("FASTSLAM_POSE", pose);
  };
  told_after([](const status_t& s) { return value_of(s, "store_commits") > 0; }, drive);
  ASSERT_FALSE(HasFailure());
  const Utime before = reported(drive);
  rlimit limit{1, RLIM_INFINITY};
  ASSERT_EQ(prlimit(program_->pid(), RLIMIT_FSIZE, &limit, nullptr), 0);
  const double told = told_after(
      [](const status_t& s) { return s.detail.find("map's file is not written") != std::string::npos; },
      drive);
  expect_told_early(before);
  const double commits = value_of(*bus_.status("map-server"), "store_commits");
  limit.rlim_cur = RLIM_INFINITY;
  ASSERT_EQ(prlimit(program_->pid(), RLIMIT_FSIZE, &limit, nullptr), 0);
  const double recovered = told_after(
      [&](const status_t& s) { return s.detail.empty() && value_of(s, "store_commits") > commits; }, drive);
  print("full disk", told, recovered);
}

TEST_F(Detection, ABrokerThatDies) {
  if (BrokerProgram::find().empty())
    GTEST_SKIP() << "no mosquitto on this machine: apt-get install mosquitto";
  if (!std::filesystem::exists(find_program("lcmslam-bridge")))
    GTEST_SKIP() << "no bridge was built: libmosquitto-dev is not installed";
  BrokerProgram broker(folder_);
  start("bridge", "  host: 127.0.0.1\n  port: " + std::to_string(broker.port) +
                      "\n  robot: dora\n  longest_pause: 1\n  send: [ICP_KEYFRAME, ICP_POSE]\n");
  Mapper mapper(bus_);
  const auto is_connected = [](const status_t& s) { return value_of(s, "connected") == 1; };
  told_after(is_connected);
  ASSERT_FALSE(HasFailure());
  const Utime before = reported();
  broker.kill_hard();
  const double told = told_after([&](const status_t& s) { return !is_connected(s); }, [&] { mapper.pose(); });
  expect_told_early(before);
  mapper.keyframe(1000);
  broker.start();
  const double recovered =
      told_after([&](const status_t& s) { return is_connected(s) && value_of(s, "kept_waiting") == 0; });
  print("broker dies", told, recovered);
}

// Another driver's process that ends, or whose plug was pulled.
TEST_F(Detection, ACameraThatGivesNothingMore) {
  lcmslam::testing::write_head(folder_ / "head.yaml", {640, 480});
  start("camera", "  source: channel\n  channel: {channel: OPENNI_FRAME}\n  live: {calibration: '" +
                      (folder_ / "head.yaml").string() + "'}\n");
  Mapper mapper(bus_);
  const auto drive = [&] { mapper.picture("OPENNI_FRAME"); };
  const auto runs = [](const status_t& s) { return s.state == status_t::RUNNING; };
  told_after(runs, drive);
  ASSERT_FALSE(HasFailure());
  const double told = told_after([&](const status_t& s) { return !runs(s); });
  EXPECT_THAT(bus_.status("camera")->detail, HasSubstr("no image"));
  const double recovered = told_after(runs, drive);
  print("camera gives nothing more", told, recovered);
  EXPECT_LT(told, soon * patience_factor);
}

// A sender that hangs: its process lives and does nothing.
TEST_F(Detection, MeasurementsThatComeNoMore) {
  start("odometry", "  source: twist\n");
  twist_t twist{};
  twist.sender = 77;
  const auto drive = [&] {
    twist.utime = wall_clock();
    ++twist.seq;
    bus_.publish("TWIST", twist);
  };
  const auto stopped = [](const status_t& s) {
    return s.detail.find("TWIST comes no more") != std::string::npos;
  };
  std::int64_t sent = 0;
  told_after([&](const status_t&) { return sent > 50; }, [&] { drive(), ++sent; });
  ASSERT_FALSE(HasFailure());
  EXPECT_FALSE(stopped(*bus_.status("odometry")));
  const double told = told_after(stopped);
  const double recovered = told_after([&](const status_t& s) { return !stopped(s); }, drive);
  print("measurements come no more", told, recovered);
  EXPECT_LT(told, soon * patience_factor);
}

TEST_F(Detection, StrangersOnTheBus) {
  start("odometry", "  source: twist\n");
  told_after([](const status_t&) { return true; });
  ASSERT_FALSE(HasFailure());
  twist_t twist{};
  const auto drive = [&](std::int64_t sender, int& seq) {
    twist.utime = wall_clock();
    twist.sender = sender;
    twist.seq = seq++;
    bus_.publish("TWIST", twist);
  };
  int own = 0, foreign = 0;
  const auto go_on = [&] { drive(77, own); };
  told_after([&](const status_t&) { return own > 50; }, go_on);
  const MulticastAddress address = multicast_address(lcm_url_from_environment());
  const lcmslam::testing::UdpSender stranger;

  const auto errors = [](const status_t& s) {
    double sum = 0;
    for (const auto& input : s.inputs) sum += static_cast<double>(input.decode_errors);
    return sum;
  };
  const auto bytes = lcmslam::testing::bytes_of;
  expect_told_soon(
      "garbage", [&] { bus_.publish("TWIST", bytes("no message of this type")); }, errors, go_on);
  expect_told_soon(
      "killing datagrams",
      [&] {
        for (const lcmslam::testing::Bytes& datagram : lcmslam::testing::killing_datagrams("TWIST"))
          stranger.send(address.group, address.port, datagram);
      },
      value("bus_malformed"), go_on);
  expect_told_soon(
      "no datagram of LCM", [&] { stranger.send(address.group, address.port, bytes("no datagram of LCM")); },
      value("bus_malformed"), go_on);
  expect_told_soon(
      "another sender", [&] { drive(99, foreign); }, value("of_other_senders"), go_on);
}

// Browsers and questions, which the bus's own counters do not know.
TEST_F(Detection, StrangersAtThePage) {
  start("map-server", "  folder: '" + folder_.path().string() + "'\n  page: {web: {port: 0}}\n");
  told_after([](const status_t&) { return true; });
  ASSERT_FALSE(HasFailure());
  const std::string output = program_->output(), named = "the live page: http://127.0.0.1:";
  const std::size_t at = output.find(named);
  ASSERT_NE(at, std::string::npos) << output;
  const int port = std::stoi(output.substr(at + named.size()));
  lcmslam::testing::WebClient foreign(port), command(port);
  expect_told_soon(
      "a foreign site",
      [&] { EXPECT_FALSE(foreign.open_socket("/live", "Origin: http://evil.example\r\n")); },
      value("page_refused"));
  ASSERT_TRUE(command.open_socket("/command"));
  expect_told_soon(
      "a page's order that is none", [&] { EXPECT_TRUE(command.say(R"({"do": "dance"})")); },
      value("page_commands_refused"));
  map_request_t request{};
  request.kind = 99;
  expect_told_soon(
      "a request that is none", [&] { bus_.publish("MAP_REQUEST", request); }, value("requests_refused"));
}

// However many they are: a report takes time, and others must be heard.
TEST_F(Detection, AFloodOfStrangersMakesNoFloodOfReports) {
  start("odometry", "  source: wheels\n");
  told_after([](const status_t&) { return true; });
  ASSERT_FALSE(HasFailure());
  const std::int64_t pid = program_->pid();
  const MulticastAddress address = multicast_address(lcm_url_from_environment());
  const lcmslam::testing::UdpSender stranger;
  const std::size_t reports = bus_.status_count("odometry", pid);
  const auto begin = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  wait_until(
      [&] {
        for (int i = 0; i < 10; ++i)
          stranger.send(address.group, address.port, lcmslam::testing::bytes_of("no datagram of LCM"));
        return seconds() > 3;
      },
      patience);
  EXPECT_LE(static_cast<double>(bus_.status_count("odometry", pid) - reports), 2 * seconds() + 2);
}

}  // namespace
}  // namespace lcmslam::integration
