// A running graph answers questions.

#include <gmock/gmock.h>

#include <lcmslam/map_client/map_client.hpp>
#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"

namespace lcmslam::integration {
namespace {

using ::testing::HasSubstr;

TEST(Query, NobodyThereIsAnError) {
  const Result result = run({"lcmslam", "query", "grid", "deadline=1"}, 30);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("no answer from a map server"));
}

TEST(Query, WrongQuestionsAreErrors) {
  EXPECT_EQ(run({"lcmslam", "query", "weather"}, 30).exit_code, 2);
  EXPECT_EQ(run({"lcmslam", "query", "mesh"}, 30).exit_code, 2);
  EXPECT_THAT(run({"lcmslam", "query", "distance", "points=1,2"}, 30).output, HasSubstr("'points'"));
}

TEST(Query, ARunningGraphAnswers) {
  TemporaryFolder folder;
  Bus bus;
  Program launch({"lcmslam", "launch", source_folder() / "config/demo.yaml", "--out", folder.path()});
  ASSERT_TRUE(bus.wait_for_status(
      "map-server", [](const status_t& s) { return value_of(s, "layer_keyframes") >= 3; }, 120))
      << launch.output();

  MapClient map("", 20);
  const auto frontiers = map.ask({FrontiersQuestion{}, 20});
  EXPECT_EQ(frontiers.content, "application/json");
  EXPECT_EQ(frontiers.frame, "map");
  EXPECT_GT(frontiers.map_version, 3);
  const Points far = {{500, 0, 0}};
  EXPECT_EQ(map.space(far), std::vector{MapClient::Space::unknown});
  EXPECT_NEAR(map.distances(far)[0].distance, 2, 1e-9);
  EXPECT_EQ(map.collides({Sphere{far[0], 0.1}}), std::vector{false});
  Box robot;
  robot.T_map_box.translation().z() = 0.55;
  robot.half_size = {0.1, 0.1, 0.5};
  // Straight on the room ends.
  std::vector<Eigen::Isometry3d> path;
  for (double x = 0; x < 8; x += 0.05) path.push_back(planar_pose(x, 0, 0));
  const auto hit = map.first_collision(robot, path);
  ASSERT_TRUE(hit);
  EXPECT_GT(*hit, 5U);
  EXPECT_FALSE(map.first_collision(robot, {path[0]}));
  Box there = robot;
  there.T_map_box = path[*hit] * robot.T_map_box;
  EXPECT_EQ(map.collides({there, Sphere{far[0], 0.1}}), (std::vector{true, false})) << "in the order asked";

  const Result mesh = run({"lcmslam", "query", "mesh", "--out", folder / "mesh.ply"}, 60);
  EXPECT_EQ(mesh.exit_code, 0) << mesh.output;
  EXPECT_GT(std::filesystem::file_size(folder / "mesh.ply"), 100'000U);
  try {
    map.ask({LocaliseQuestion{}, 20});
  } catch (const MapError& error) {
    EXPECT_NE(std::string(error.what()), "");
  }
}

}  // namespace
}  // namespace lcmslam::integration
