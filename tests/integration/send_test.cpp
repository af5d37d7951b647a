// What `lcmslam send` says is what the graph does.

#include <gmock/gmock.h>

#include <cmath>

#include <lcmslam/runtime/options.hpp>
#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"

namespace lcmslam::integration {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Result send(std::vector<std::string> words) {
  words.insert(words.begin(), {"lcmslam", "send"});
  return run(words, 90);
}

TEST(Send, NobodyThereIsAnError) {
  const Result result = send({"save"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, AllOf(HasSubstr("no process sends STATUS"), HasSubstr("--lcm-url")));
}

TEST(Send, WrongWordsAreErrors) {
  EXPECT_EQ(send({"jump"}).exit_code, 2);
  EXPECT_EQ(send({"save", "evening"}).exit_code, 2);
  EXPECT_THAT(send({"smooth", "--to", "icp"}).output, HasSubstr("fastslam does"));
}

TEST(Send, EachOrderIsCarriedOutAndAnswered) {
  TemporaryFolder folder;
  Bus bus;
  Program launch({"lcmslam", "launch", source_folder() / "config/demo.yaml", "--out", folder.path(), "--set",
                  "map-server.snapshot_period=0"});
  const auto has = [](const char* name, double least) {
    return [name, least](const status_t& s) { return value_of(s, name) >= least; };
  };
  ASSERT_TRUE(bus.wait_for_status("map-server", has("keyframes", 2), 120)) << launch.output();
  ASSERT_TRUE(bus.wait_for_status("map-server", has("landmarks", 20), 60)) << launch.output();

  const Result saved = send({"save"});
  EXPECT_EQ(saved.exit_code, 0) << saved.output;
  EXPECT_THAT(saved.output, HasSubstr("map-server: the maps are saved"));
  EXPECT_TRUE(std::filesystem::exists(folder / "icp_map.ply"));

  const Result exported = send({"export", "evening", "--format", "ply"});
  EXPECT_EQ(exported.exit_code, 0) << exported.output;
  EXPECT_THAT(exported.output, HasSubstr("evening/icp_map.ply"));
  EXPECT_TRUE(std::filesystem::exists(folder / "evening/icp_map.ply"));
  EXPECT_FALSE(std::filesystem::exists(folder / "evening/icp_map.pcd"));
  const Result refused = send({"export", "../evening"});
  EXPECT_EQ(refused.exit_code, 1) << refused.output;

  const Result smoothed = send({"smooth"});
  EXPECT_EQ(smoothed.exit_code, 0) << smoothed.output;
  EXPECT_GT(bus.count("FASTSLAM_SMOOTHED"), 0U);

  const Result reset = send({"reset"});
  EXPECT_EQ(reset.exit_code, 0) << reset.output;
  EXPECT_TRUE(wait_until([&] { return std::filesystem::exists(folder / "before-reset-1/icp_map.ply"); }, 30));
  EXPECT_FALSE(std::filesystem::exists(folder / "before-reset-2"));
  EXPECT_TRUE(std::isnan(value_of(*bus.status("camera"), "commands_refused")));

  const Result stopped = send({"stop"});
  EXPECT_EQ(stopped.exit_code, 0) << stopped.output;
  for (const std::string& process : process_names())
    EXPECT_THAT(stopped.output, HasSubstr(process + ": stops"));
  EXPECT_EQ(launch.wait(60).exit_code, 0) << launch.output();
}

}  // namespace
}  // namespace lcmslam::integration
