#include "tools/launch/graph.hpp"

#include <gmock/gmock.h>

#include "tests/unit/tools/scratch.hpp"

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
    return read_graph(options);
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

}  // namespace
}  // namespace lcmslam
