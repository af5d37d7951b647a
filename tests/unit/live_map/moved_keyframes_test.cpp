// When what the graph has moved is made anew.

#include <lcmslam/live_map/moved_keyframes.hpp>

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/unit/live_map/seen_walls.hpp"

namespace lcmslam {
namespace {

TEST(MovedKeyframes, ArePassedOnWhenOneMovedTooFar) {
  MovedKeyframes moved(0.1, 0.05);
  moved.add(1, Eigen::Isometry3d::Identity());
  moved.add(2, Eigen::Isometry3d::Identity());
  moved.correct({{1, planar_pose(0.09, 0, 0)}, {3, planar_pose(9, 0, 0)}});
  EXPECT_FALSE(moved.due());
  moved.correct({{2, planar_pose(0, 0, 0.06)}});
  EXPECT_TRUE(moved.due());
  EXPECT_EQ(moved.take().size(), 2U);
  EXPECT_FALSE(moved.due());
  EXPECT_TRUE(moved.take().empty());
}

TEST(MovedKeyframes, WaitForFramesWhereThereAreManyOfThem) {
  MovedKeyframes moved(0.1, 0.05);
  for (int id = 0; id < 40; ++id) moved.add(id, Eigen::Isometry3d::Identity());
  moved.correct({{1, planar_pose(1, 0, 0)}});
  EXPECT_TRUE(moved.due()) << "the first time at once";
  moved.take();
  moved.correct({{1, planar_pose(2, 0, 0)}});
  for (int frame = 0; frame < 9; ++frame) moved.frame();
  EXPECT_TRUE(moved.moved());
  EXPECT_FALSE(moved.due());
  moved.frame();
  EXPECT_TRUE(moved.due());
}

TEST(MovedKeyframes, WithoutOneThatIsGivenUpAllIsDueAnew) {
  MovedKeyframes moved(0.1, 0.05);
  moved.add(1, Eigen::Isometry3d::Identity());
  moved.give_up(1);
  moved.correct({{1, planar_pose(9, 0, 0)}});
  EXPECT_TRUE(moved.due());
  EXPECT_TRUE(moved.take().empty());
  EXPECT_FALSE(moved.moved());
}

TEST(LiveMap, ASmallCorrectionLeavesSpaceAsItIs) {
  LiveMap map(some_camera(), waiting());
  map.keep(1, wall(2.02), at(0));
  ASSERT_EQ(state(map, 2.02), CellState::occupied);
  map.correct({{1, at(0.015).T_map_camera}});
  EXPECT_EQ(state(map, 2.02), CellState::occupied);
  map.correct({{1, at(0.3).T_map_camera}});
  EXPECT_EQ(state(map, 2.32), CellState::occupied);
  EXPECT_NE(state(map, 2.02), CellState::occupied);
}

TEST(LiveMap, ARobotThatStandsStillSeesTheGraphsLastCorrection) {
  LiveMap map(some_camera(), waiting());
  for (int id = 0; id < 12; ++id) map.keep(id, wall(2), at(0));
  const auto all_at = [&](double x) {
    std::map<int, Eigen::Isometry3d> poses;
    for (int id = 0; id < 12; ++id) poses[id] = at(x).T_map_camera;
    return poses;
  };
  map.correct(all_at(0.4));
  EXPECT_EQ(state(map, 2.42), CellState::occupied);
  map.correct(all_at(0.8));
  for (int frame = 0; frame < 5; ++frame) map.show(wall(2), at(10));  // of another place
  EXPECT_EQ(state(map, 2.82), CellState::occupied);
  EXPECT_NE(state(map, 2.42), CellState::occupied);
  ASSERT_FALSE(map.planes().empty());
  EXPECT_NEAR(map.planes().front().fit.centre.x(), 2.8, 0.02);
}

// A log at its end, a camera that is off: what the graph says last is not left for the next frame.
TEST(LiveMap, CatchesUpWhereNoFrameComes) {
  for (const bool background : {false, true}) {
    LiveMapSettings settings = waiting();
    settings.background = background;
    LiveMap map(some_camera(), settings);
    for (int own = 0; own < 10; ++own) map.keep(own, wall(2), at(10 * own));
    const auto bend = [&](double x) {
      std::map<int, Eigen::Isometry3d> moved;
      for (int own = 0; own < 10; ++own) moved[own] = at(10 * own + x).T_map_camera;
      map.correct(moved);
    };
    bend(0.2);
    map.settle();
    bend(0.4);
    EXPECT_NE(state(map, 2.4), CellState::occupied) << "no frame has come";
    const std::int64_t version = map.version();
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (map.catch_up() && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    EXPECT_EQ(state(map, 2.4), CellState::occupied);
    EXPECT_GT(map.version(), version) << "whoever draws it learns of it";
    EXPECT_FALSE(map.catch_up());
  }
}

}  // namespace
}  // namespace lcmslam
