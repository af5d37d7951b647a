// What the doctor finds on machines that are well and on machines that are made ill.

#include <gmock/gmock.h>

#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>
#include <atomic>
#include <thread>

#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/private_bus.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include <lcmslam/runtime/udpm/multicast_address.hpp>
#include <lcmslam/status_t.hpp>
#include "tests/support/datagrams.hpp"
#include "tests/support/own_bus.hpp"
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/log_samples.hpp"
#include "tools/doctor/checks.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Level = Finding::Level;

const std::string url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=212992";

DoctorOptions quick(const std::string& lcm_url) {
  DoctorOptions options;
  options.lcm_url = lcm_url;
  options.seconds = 0.3;
  return options;
}

TEST(MulticastAddress, IsReadOrRefusedWithWhatWouldBeRight) {
  const MulticastAddress address = multicast_address("udpm://239.1.2.3:1234?recv_buf_size=9&ttl=2");
  EXPECT_EQ(address.group, "239.1.2.3");
  EXPECT_EQ(address.port, 1234);
  EXPECT_EQ(address.ttl, 2);
  EXPECT_EQ(multicast_address("memq://").group, "");
  for (const char* wrong : {"udpm://", "udpm://239.1.2.3", "udpm://10.0.0.1:7667", "udpm://239.1.2.3:99999",
                            "udpm://239.1.2.3:x", "udpm://robot:7667"})
    try {
      multicast_address(wrong);
      ADD_FAILURE() << wrong;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr(wrong));
      EXPECT_THAT(error.what(), HasSubstr("udpm://239.255.76.67:7667"));
    }
}

// In a process of its own, which then has no network at all.
TEST(Doctor, NamesTheRouteThatIsMissing) {
  const pid_t child = fork();
  if (child == 0) {
    if (unshare(geteuid() == 0 ? CLONE_NEWNET : CLONE_NEWUSER | CLONE_NEWNET) != 0) _exit(77);
    const Finding finding = check_route(url);
    const bool right =
        finding.level == Level::failure && finding.text.find("239.255.76.67") != std::string::npos &&
        finding.cure == "sudo ip route add 224.0.0.0/4 dev lo" && examine(quick(url)).size() == 3;
    _exit(right ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 77)
    GTEST_SKIP() << "no network namespace is permitted here";
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

TEST(Doctor, FindsAPrivateBusWell) {
  if (!enter_private_bus()) GTEST_SKIP() << "this machine permits no private network namespace";
  const Finding route = check_route(url);
  EXPECT_EQ(route.level, Level::good) << route.text;
  EXPECT_THAT(route.text, HasSubstr("through lo"));
  EXPECT_EQ(check_route("udpm://239.255.76.67:7667?ttl=1").level, Level::warning);
  const Finding test = check_loop_back(quick(url));
  EXPECT_EQ(test.level, Level::good) << test.text;
  EXPECT_THAT(test.text, HasSubstr("9 of 9 messages of 300 kB"));
  EXPECT_THAT(test.text, HasSubstr("in pieces"));
  for (const Finding& finding : check_traffic(quick(url)))
    EXPECT_EQ(finding.level, Level::good) << finding.text;
}

TEST(Doctor, SaysWhoMayBeHeard) {
  EXPECT_EQ(check_sources("memq://").level, Level::good);
  EXPECT_THAT(check_sources(url).text, HasSubstr("this machine alone"));
  const std::string open = "udpm://239.255.76.67:7667?ttl=1";
  EXPECT_EQ(check_sources(open).level, Level::warning);
  EXPECT_THAT(check_sources(open).text, HasSubstr("LCMSLAM_BUS_ALLOW"));
  setenv("LCMSLAM_BUS_ALLOW", "10.0.0.5", 1);
  EXPECT_EQ(check_sources(open).level, Level::good);
  unsetenv("LCMSLAM_BUS_ALLOW");
}

/// While a datagram that is none of LCM's is sent over and over, and a STATUS of a
/// process that has refused some.
TEST(Doctor, ShowsWhatWasRefused) {
  const std::string bus = own_bus(url);
  std::atomic<bool> stop{false};
  std::thread stranger([&] {
    const testing::UdpSender sender;
    status_t status{};
    status.process = "surf";
    status.pid = 4711;
    status.n_values = 1;
    status.values.resize(1);
    status.values[0].name = "bus_foreign";
    status.values[0].value = 9;
    while (!stop) {
      const auto now = std::chrono::system_clock::now().time_since_epoch();
      status.utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
      const MulticastAddress address = multicast_address(bus);
      sender.send(address.group, address.port, testing::whole_datagram("STATUS", encode_message(status)));
      sender.send(address.group, address.port, testing::bytes_of("no datagram of LCM"));
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  const auto findings = check_traffic(quick(bus));
  stop = true;
  stranger.join();
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].subject, "other senders");
  EXPECT_EQ(findings[1].subject, "refused packets");
  EXPECT_EQ(findings[1].level, Level::warning);
  EXPECT_THAT(findings[1].text, HasSubstr("malformed (no datagram of LCM)"));
  EXPECT_THAT(findings[1].text, HasSubstr("surf (4711) refused 9 since its start"));
}

TEST(Doctor, NoticesABusThatDoesNotKeepUp) {
  if (!enter_private_bus()) GTEST_SKIP() << "this machine permits no private network namespace";
  DoctorOptions options = quick(url);
  options.traffic.largest = 1'000'000;  // 17 pieces, paced
  options.traffic.rate = 100;
  const Finding test = check_loop_back(options);
  EXPECT_GE(test.level, Level::warning) << test.text;
  EXPECT_THAT(test.text, HasSubstr("pile up"));
}

TEST(Doctor, NamesNoCureOfMulticastForOtherBuses) {
  const Finding memory = check_loop_back(quick("memq://"));  // each end has one of its own
  EXPECT_EQ(memory.level, Level::failure);
  EXPECT_EQ(memory.cure, "");
  EXPECT_EQ(check_loop_back(quick("tcpq://127.0.0.1:1")).level, Level::failure);  // nobody serves it
  EXPECT_EQ(check_senders(quick("tcpq://127.0.0.1:1")).level, Level::failure);
}

TEST(Doctor, SaysWhatASmallBufferMeans) {
  const std::string tiny = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2000";
  const Finding buffer = check_receive_buffer(tiny, {});
  EXPECT_EQ(buffer.level, Level::note);
  EXPECT_THAT(buffer.text, HasSubstr("above 60 kB"));
  EXPECT_THAT(buffer.cure, HasSubstr("rmem_max"));
  EXPECT_EQ(check_receive_buffer("memq://", {}).level, Level::good);
}

TEST(GraphTraffic, IsMeasuredOnTheImagesThatTheConfigurationWouldSend) {
  const std::string demo = source_folder() / "config/demo.yaml";
  const GraphTraffic tof = graph_traffic(demo, {"camera.simulation.frame_rate=10"});
  EXPECT_NEAR(tof.rate, 10, 1e-3);
  EXPECT_THAT(tof.origin, HasSubstr("measured"));
  const GraphTraffic rgbd = graph_traffic(demo, {"camera.simulation.head=rgbd", "camera.speed=2"});
  EXPECT_GT(rgbd.largest, tof.largest);
  EXPECT_LT(rgbd.largest, 450'000U);
  const GraphTraffic elsewhere = graph_traffic(source_folder() / "config/replay.yaml", {});
  EXPECT_EQ(elsewhere.largest, 300'000U);
  EXPECT_THAT(elsewhere.origin, HasSubstr("assumed"));
  EXPECT_THROW(graph_traffic(demo, {"camera.simulation.scene=none.yaml"}), std::exception);
  EXPECT_THAT(tof.doubts, IsEmpty());
  EXPECT_THAT(tof.depths, HasSubstr(" m"));
}

TEST(GraphTraffic, OfAPresetNamesWhatNobodyHasSaid) {
  const std::string preset = source_folder() / "config/modern.yaml";
  try {
    graph_traffic(preset, {});
    ADD_FAILURE();
  } catch (const std::exception& error) {
    EXPECT_THAT(error.what(), ::testing::AllOf(HasSubstr(preset + ": names no camera.source"),
                                               ::testing::Not(HasSubstr("--set"))));
  }
  EXPECT_THAT(graph_traffic(preset, {"launch.processes=[icp]"}).origin, HasSubstr("assumed"));
}

/// A recording's first images: their rate is tried for a moment, whatever their stamps say.
TEST(GraphTraffic, TakesNoRateOfGapsAndLeapsOfStamps) {
  const testing::ScratchFolder scratch;
  const std::string file = (scratch.path() / "a.lcmlog").string();
  const auto rate = [&](const std::vector<Utime>& stamps) {
    LogWriter log(file);
    log.write(testing::sample_start, "CAMERA_CALIBRATION",
              testing::calibration_message(testing::sample_start, 0));
    for (std::size_t i = 0; i < stamps.size(); ++i)
      log.write(testing::sample_start + stamps[i], "CAMERA",
                testing::camera_message(testing::sample_start + stamps[i], static_cast<std::int64_t>(i)));
    log.close();
    return graph_traffic(source_folder() / "config/dataset.yaml",
                         {"camera.source=log", "camera.log.file=" + file})
        .rate;
  };
  EXPECT_NEAR(rate({0, 33'333, 66'666, 99'999}), 30, 1e-3);
  EXPECT_NEAR(rate({0, 33'333, 600'033'333, 600'066'666}), 30, 1e-3) << "a gap of ten minutes";
  EXPECT_EQ(rate({0, 1, 2, 3}), 200);
  EXPECT_EQ(rate({0, 20'000'000, 40'000'000, 60'000'000}), 1);
}

// In a process of its own, which is asked to stop for good.
TEST(Doctor, StopsTryingTheBusWhenItIsTold) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);
    DoctorOptions options = quick("memq://");
    options.traffic.rate = 1;
    options.seconds = 3600;
    request_stop();
    _exit(check_loop_back(options).text.find("stopped") != std::string::npos ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

/// What is found while a STATUS of that age is on the bus; `processes`: those to be launched. One that stops
/// says so after its first messages.
Finding senders_beside(std::chrono::system_clock::duration age, std::vector<std::string> processes = {},
                       bool stops = false) {
  static const std::string bus = own_bus(url);
  std::atomic<bool> stop{false};
  std::thread other([&] {
    lcm::LCM lcm(bus);
    LcmPublisher publisher(lcm, 3, 1'000'000);
    status_t status{};
    status.process = "surf";
    status.pid = 4711;
    for (int message = 0; !stop; ++message) {
      status.state = stops && message > 20 ? status_t::STOPPING : status_t::RUNNING;
      const auto time = (std::chrono::system_clock::now() - age).time_since_epoch();
      status.utime = std::chrono::duration_cast<std::chrono::microseconds>(time).count();
      publisher.publish("STATUS", status);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  DoctorOptions options = quick(bus);
  options.processes = std::move(processes);
  const Finding finding = check_senders(options);
  stop = true;
  other.join();
  return finding;
}

TEST(Doctor, SaysWhatLooksWrongWithTheImages) {
  EXPECT_THAT(check_images({}), IsEmpty()) << "none were seen";
  GraphTraffic traffic;
  traffic.depths = "90 % of the pixels have a depth";
  ASSERT_THAT(check_images(traffic), SizeIs(1));
  EXPECT_EQ(check_images(traffic)[0].level, Finding::Level::good);
  traffic.doubts = {"the mount", "the depth scale"};
  const auto findings = check_images(traffic);
  ASSERT_THAT(findings, SizeIs(2));
  EXPECT_EQ(findings[1].level, Finding::Level::warning);
  EXPECT_THAT(findings[1].text, HasSubstr("the depth scale"));
}

TEST(Doctor, NamesTheGraphThatRunsAlready) {
  const Finding finding = senders_beside(std::chrono::seconds(0));
  EXPECT_EQ(finding.level, Level::warning);
  EXPECT_THAT(finding.text, HasSubstr("surf (4711)"));
}

TEST(Doctor, APlayedRecordingIsNoRivalGraph) {
  const Finding live = senders_beside(std::chrono::seconds(1), {"icp", "surf"});
  EXPECT_TRUE(is_rival_graph(live)) << live.text;
  EXPECT_THAT(live.text, HasSubstr("runs here already: surf (4711)"));
  for (const int hours : {1, 20'000, -1}) {
    const Finding played = senders_beside(std::chrono::hours(hours), {"icp", "surf"});
    EXPECT_FALSE(is_rival_graph(played)) << played.text;
    EXPECT_EQ(played.level, Level::warning);
    EXPECT_THAT(played.text, HasSubstr("others send here: STATUS"));
    EXPECT_THAT(played.text, HasSubstr("a recording of a graph is played"));
    EXPECT_THAT(played.text, HasSubstr("surf (4711)"));
  }
}

TEST(Doctor, AGraphThatEndsMeanwhileIsNoRival) {
  const Finding ending = senders_beside(std::chrono::seconds(0), {"icp", "surf"}, true);
  EXPECT_FALSE(is_rival_graph(ending)) << ending.text;
  EXPECT_THAT(ending.text, HasSubstr("others send here: STATUS"));
}

TEST(Doctor, ReadsTheGovernor) {
  testing::ScratchFolder scratch;
  const auto folder = scratch.path() / "sys/devices/system/cpu/cpu0/cpufreq";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "scaling_governor") << "performance\n";
  EXPECT_EQ(check_governor(scratch.path()).level, Level::good);
  std::ofstream(folder / "scaling_governor") << "powersave\n";
  EXPECT_EQ(check_governor(scratch.path()).level, Level::note);
  EXPECT_EQ(check_governor(scratch.path() / "nothing").level, Level::good);
}

TEST(Doctor, MissesAFolderThatIsNotThere) {
  EXPECT_EQ(check_disk("/no/such/folder").level, Level::failure);
  EXPECT_THAT(check_disk("/no/such/folder").text, HasSubstr("/no/such/folder"));
}

TEST(Doctor, PrintsTheCureBelowTheFinding) {
  const std::vector<Finding> findings{{Level::good, "a", "fine", ""},
                                      {Level::warning, "b", "ill", "do this"}};
  EXPECT_EQ(worst(findings), Level::warning);
  EXPECT_THAT(format_findings(findings, true), HasSubstr("fine"));
  const std::string brief = format_findings(findings, false);
  EXPECT_EQ(brief.find("fine"), std::string::npos);
  EXPECT_THAT(brief, HasSubstr("ill\n           do this\n"));
}

}  // namespace
}  // namespace lcmslam
