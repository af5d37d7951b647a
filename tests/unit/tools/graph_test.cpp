#include "tools/launch/graph.hpp"

#include <gmock/gmock.h>

#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/commands.hpp"
#include "tools/launch/hosts.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Graph : public ::testing::Test {
 protected:
  std::vector<ProcessSpec> read(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
    GraphOptions options;
    options.config = scratch_.write("graph.yaml", yaml);
    options.lcm_url = "memq://";
    options.overrides = overrides;
    options.folder = scratch_.path() / "run";
    return read_graph(options).processes;
  }
  std::string error_of(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
    try {
      read(yaml, overrides);
      return {};
    } catch (const ConfigError& error) {
      return error.what();
    }
  }
  testing::ScratchFolder scratch_;
};

TEST_F(Graph, NamesProgramsArgumentsAndLogs) {
  const auto specs = read("launch: {processes: [camera, map-server], restart: false}\nicp: {any: thing}\n",
                          {"camera.speed=2"});
  ASSERT_EQ(specs.size(), 2U);
  EXPECT_EQ(specs[1].name, "map-server");
  EXPECT_EQ(specs[1].arguments[0], (program_folder() / "lcmslam-map-server").string());
  EXPECT_THAT(specs[0].arguments, AllOf(Contains((scratch_.path() / "graph.yaml").string()),
                                        Contains("memq://"), Contains("camera.speed=2")));
  EXPECT_FALSE(specs[0].restart);
  EXPECT_EQ(specs[0].log, scratch_.path() / "run/logs/camera.txt");
  EXPECT_TRUE(std::filesystem::is_directory(scratch_.path() / "run/logs"));
}

// A service that came back to it every five seconds would fill the disk with folders.
TEST_F(Graph, AWrongConfigurationEndsWithTwoAndLeavesNoFolder) {
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(scratch_.path());
  const std::string demo = (source_folder() / "config/demo.yaml").string();
  for (const std::string& yaml :
       {std::string("launch: ["), std::string("launch: {restrat: true}\n"),
        "include: " + demo + "\nlaunch: {restrat: true}\n", std::string("include: /nowhere.yaml\n"),
        std::string("- surf\n"), std::string()}) {
    SCOPED_TRACE(yaml);
    const std::string file = scratch_.write("wrong.yaml", yaml);
    EXPECT_EQ(testing::run_command({"launch", launch_command}, {file, "--lcm-url", "memq://"}).exit_code, 2);
    EXPECT_EQ(
        testing::run_command({"demo", demo_command}, {"--config", file, "--lcm-url", "memq://"}).exit_code,
        2);
    EXPECT_FALSE(std::filesystem::exists("out"));
  }
  GraphOptions sound;
  sound.config = demo;
  EXPECT_EQ(read_graph(sound).processes.size(), 6U);
  EXPECT_FALSE(std::filesystem::exists("logs")) << "it was only asked";
  std::filesystem::current_path(before);
}

TEST_F(Graph, WithoutALaunchSectionAllProcessesRun) {
  const auto specs = read("icp: {}\n");
  EXPECT_EQ(specs.size(), 6U);
  EXPECT_TRUE(specs[0].restart);
}

TEST_F(Graph, OverridesReachTheLaunchSection) {
  EXPECT_EQ(read("icp: {}\n", {"launch.processes=[surf]"}).size(), 1U);
}

TEST_F(Graph, AGraphOfNothingOrOfTheSameTwiceIsRefused) {
  EXPECT_THAT(error_of("launch:\n  processes: []\n"),
              AllOf(HasSubstr("graph.yaml:2"), HasSubstr("at least one process")));
  EXPECT_THAT(error_of("launch: {processes: [surf, icp, surf]}\n"),
              AllOf(HasSubstr("graph.yaml:1"), HasSubstr("each process once, got [surf, icp, surf]")));
  EXPECT_THAT(error_of(""), AllOf(HasSubstr("graph.yaml"), HasSubstr("is empty"), HasSubstr("include:")));
  EXPECT_THAT(error_of("# nothing\n"), HasSubstr("is empty"));
  EXPECT_THAT(error_of(std::string(4, '\0')), HasSubstr("graph.yaml:1: a byte of value 0"));
}

TEST_F(Graph, ErrorsNameWhatIsWrong) {
  EXPECT_THAT(error_of("launch: {processes: [camera, slam]}\n"),
              AllOf(HasSubstr("graph.yaml"), HasSubstr("got 'slam'")));
  EXPECT_THAT(error_of("launch: {process: [camera]}\n"), HasSubstr("process"));
  EXPECT_THAT(error_of("launch: {restart: perhaps}\n"), HasSubstr("restart"));
  EXPECT_THAT(error_of("lunch: {restart: true}\n"), HasSubstr("lunch"));
  EXPECT_THAT(error_of("[1, 2]\n"), HasSubstr("graph.yaml"));
  EXPECT_THAT(error_of("launch: {}\n", {"launch.restart"}), HasSubstr("section.key=value"));
  GraphOptions options;
  options.config = "/no/such/graph.yaml";
  EXPECT_THROW(read_graph(options), ConfigError);
}

TEST_F(Graph, SaysHowEachProcessIsStarted) {
  const auto specs = read(
      "launch:\n  processes: [camera, icp]\n  restart_limit: 4\n  log_size: 2\n  log_files: 5\n"
      "  icp: {after: [camera], cpus: [1, 2], nice: 5, memory: 800, environment: [OMP_NUM_THREADS=1]}\n");
  EXPECT_THAT(specs[1].after, ElementsAre("camera"));
  EXPECT_THAT(specs[1].limits.cpus, ElementsAre(1, 2));
  EXPECT_EQ(specs[1].limits.nice, 5);
  EXPECT_EQ(specs[1].limits.memory, 800'000'000U);
  EXPECT_THAT(specs[1].environment, ElementsAre("OMP_NUM_THREADS=1"));
  EXPECT_EQ(specs[0].restart_limit, 4);
  EXPECT_EQ(specs[0].log_bytes, 2'000'000U);
  EXPECT_EQ(specs[0].log_files, 5);
}

TEST_F(Graph, WrongWordsAboutTheStartAreRefused) {
  EXPECT_THAT(error_of("launch: {processes: [camera, icp], icp: {after: [surf]}}\n"),
              AllOf(HasSubstr("icp.after"), HasSubstr("processes that run, got 'surf'")));
  EXPECT_THAT(
      error_of("launch:\n  processes: [camera, surf, icp]\n  icp: {after: [surf]}\n  surf: {after: [icp]}\n"),
      HasSubstr("circle: surf, icp, surf"));
  EXPECT_THAT(error_of("launch: {processes: [icp], icp: {environment: [THREADS]}}\n"),
              HasSubstr("NAME=VALUE"));
  EXPECT_THAT(error_of("launch: {processes: [icp], icp: {nice: 20}}\n"), HasSubstr("nice"));
  EXPECT_THAT(error_of("launch: {processes: [icp], icp: {cpu: [1]}}\n"), HasSubstr("cpu"));
}

TEST_F(Graph, EachHostStartsItsShare) {
  const std::string yaml =
      "launch:\n  processes: [camera, surf, icp]\n  host: base\n  ttl: 1\n  camera: {host: robot}\n";
  GraphOptions options;
  options.config = scratch_.write("graph.yaml", yaml);
  options.lcm_url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=1000";
  options.folder = scratch_.path() / "run";
  options.host = "base";
  const lcmslam::Graph base = read_graph(options);
  ASSERT_EQ(base.processes.size(), 2U);
  EXPECT_EQ(base.processes[0].name, "surf");
  EXPECT_THAT(base.processes[0].arguments, Contains("udpm://239.255.76.67:7667?ttl=1&recv_buf_size=1000"));
  EXPECT_EQ(base.elsewhere.at("camera"), "robot");
  EXPECT_EQ(obstacle_between_hosts(base), "");
  options.host = "robot";
  EXPECT_EQ(read_graph(options).processes.size(), 1U);
  options.host = "nobody";
  try {
    read_graph(options);
    FAIL() << "a host that has nothing to do";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("'nobody'"), HasSubstr("robot, base")));
  }
  EXPECT_THAT(error_of("launch: {processes: [camera, icp], camera: {host: robot}}\n"),
              HasSubstr("must say where icp runs"));
}

TEST_F(Graph, AGraphOfSeveralHostsNeedsATtl) {
  GraphOptions options;
  options.config =
      scratch_.write("graph.yaml", "launch: {processes: [camera, icp], host: a, icp: {host: b}}\n");
  options.lcm_url = "udpm://239.255.76.67:7667?ttl=0";
  options.folder = scratch_.path() / "run";
  options.host = "a";
  EXPECT_THAT(obstacle_between_hosts(read_graph(options)),
              AllOf(HasSubstr("icp runs on b"), HasSubstr("launch.ttl")));
  options.overrides = {"launch.ttl=1"};
  EXPECT_EQ(obstacle_between_hosts(read_graph(options)), "");
}

TEST(Elsewhere, SaysOnceThatAHostIsLostAndThatItIsHeardAgain) {
  lcmslam::Graph graph;
  graph.host = "base";
  graph.elsewhere = {{"camera", "robot"}, {"odometry", "robot"}, {"bridge", "cloud"}};
  Elsewhere elsewhere(graph, 1);
  const auto begin = Elsewhere::Clock::now();
  command_t word;
  word.name = "clock";
  word.target = "robot";
  word.sender = 2;
  word.utime = 0;
  word.n = 0;
  const auto at = [&](int ms) { return begin + std::chrono::milliseconds(ms); };
  EXPECT_THAT(elsewhere.news(at(5000)), ::testing::IsEmpty()) << "who was never heard is not lost";
  elsewhere.hear(word, 0, at(5000));
  word.target = "stranger";
  elsewhere.hear(word, 0, at(5000));
  EXPECT_THAT(elsewhere.news(at(5700)), ::testing::IsEmpty());
  EXPECT_THAT(elsewhere.news(at(5900)),
              ::testing::ElementsAre(
                  AllOf(HasSubstr("robot is lost"), HasSubstr("0.9 s"), HasSubstr("camera, odometry"))));
  EXPECT_THAT(elsewhere.news(at(9000)), ::testing::IsEmpty()) << "once";
  word.target = "robot";
  elsewhere.hear(word, 0, at(9000));
  EXPECT_THAT(elsewhere.news(at(9100)), ::testing::ElementsAre(HasSubstr("robot is heard again")));
  EXPECT_EQ(elsewhere.news(at(10'100)).size(), 1U) << "and may be lost again";
}

TEST(Ttl, IsPutIntoTheUrl) {
  EXPECT_EQ(with_ttl("udpm://239.255.76.67:7667", 1), "udpm://239.255.76.67:7667?ttl=1");
  EXPECT_EQ(with_ttl("udpm://239.255.76.67:7667?recv_buf_size=5", 1),
            "udpm://239.255.76.67:7667?recv_buf_size=5&ttl=1");
  EXPECT_EQ(with_ttl("udpm://239.255.76.67:7667?a=5&ttl=0", 2), "udpm://239.255.76.67:7667?a=5&ttl=2");
  EXPECT_EQ(with_ttl("udpm://239.255.76.67:7667?ttl=3", 0), "udpm://239.255.76.67:7667?ttl=3");
  EXPECT_EQ(with_ttl("memq://", 1), "memq://");
}

}  // namespace
}  // namespace lcmslam
