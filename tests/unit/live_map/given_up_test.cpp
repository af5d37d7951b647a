// What keyframes saw that the mapper has given up is still there, and moves with those that stay.

#include <gmock/gmock.h>

#include <vector>

#include "tests/unit/live_map/seen_walls.hpp"

namespace lcmslam {
namespace {

/// Three walls in a row, 5 m apart, each seen by a keyframe.
std::map<int, Eigen::Isometry3d> three_walls() {
  return {{1, at(0).T_map_camera}, {2, at(5).T_map_camera}, {3, at(10).T_map_camera}};
}

void keep_walls(LiveMap& map, const std::vector<int>& ids) {
  for (const int id : ids) map.keep(id, wall(2), {three_walls().at(id), Eigen::Isometry3d::Identity()});
}

/// One look makes a plane.
LiveMapSettings sure(bool background) {
  LiveMapSettings settings = waiting();
  settings.background = background;
  settings.planes.min_looks = 1;
  return settings;
}

void expect_same_layers(const LiveMap& map, const LiveMap& other) {
  for (double x = 0.02; x < 13; x += 0.04) EXPECT_EQ(state(map, x), state(other, x)) << x;
  std::vector<double> planes, others;
  for (const PlanePatch& patch : map.planes()) planes.push_back(patch.fit.centre.x());
  for (const PlanePatch& patch : other.planes()) others.push_back(patch.fit.centre.x());
  ASSERT_FALSE(planes.empty());
  EXPECT_THAT(planes, testing::Pointwise(testing::DoubleNear(1e-9), others));
  const Mesh mesh = map.settled_mesh(), without = other.settled_mesh();
  EXPECT_EQ(mesh.vertices.size(), without.vertices.size());
  EXPECT_NEAR(mean_x(mesh), mean_x(without), 1e-3);
  EXPECT_EQ(map.cloud(0.05).size(), other.cloud(0.05).size());
}

std::map<int, Eigen::Isometry3d> moved_by(double x, std::map<int, Eigen::Isometry3d> graph) {
  for (auto& [id, T] : graph) T = Eigen::Translation3d(x, 0, 0) * T;
  return graph;
}

TEST(LiveMap, WhatIsGivenUpStaysAndMovesWithTheNearestThatStays) {
  LiveMap map(some_camera(), sure(false)), whole(some_camera(), sure(false));
  for (LiveMap* of : {&map, &whole}) keep_walls(*of, {1, 2, 3});
  const auto graph = three_walls();
  map.follow({{1, graph.at(1)}, {3, graph.at(3)}});
  expect_same_layers(map, whole);
  map.follow(moved_by(0.4, {{1, graph.at(1)}, {3, graph.at(3)}}));
  map.correct(moved_by(0.8, {{1, graph.at(1)}, {3, graph.at(3)}}));
  map.settle();
  whole.follow(moved_by(0.8, graph));
  expect_same_layers(map, whole);
  EXPECT_EQ(state(map, 7.8), CellState::occupied);
  keep_walls(map, {2});
  expect_same_layers(map, whole);  // it is there
}

TEST(LiveMap, WhatHungOnAKeyframeThatIsGivenUpHangsOnTheNext) {
  LiveMap map(some_camera(), sure(false)), whole(some_camera(), sure(false));
  for (LiveMap* of : {&map, &whole}) keep_walls(*of, {1, 2, 3});
  auto graph = three_walls();
  map.follow({{1, graph.at(1)}, {3, graph.at(3)}});
  map.follow({{3, graph.at(3)}});
  map.follow(moved_by(0.4, {{3, graph.at(3)}}));
  whole.follow(moved_by(0.4, graph));
  expect_same_layers(map, whole);
}

TEST(LiveMap, WhatTheGraphHasAgainIsItsOwn) {
  LiveMap map(some_camera(), sure(false));
  keep_walls(map, {1, 2, 3});
  auto graph = three_walls();
  map.follow({{1, graph.at(1)}, {3, graph.at(3)}});
  graph.at(2) = at(6).T_map_camera;
  map.follow(graph);
  map.correct({{1, at(0.4).T_map_camera}});
  map.settle();
  for (const double x : {2.4, 8.0, 12.0}) EXPECT_EQ(state(map, x), CellState::occupied) << x;
}

TEST(LiveMap, WhatIsGivenUpMakesRoomFirst) {
  for (const bool background : {false, true}) {
    LiveMapSettings settings = sure(background);
    settings.occupancy.max_keyframes = 3;
    LiveMap map(some_camera(), settings), without(some_camera(), sure(false));
    keep_walls(map, {1, 2, 3});
    for (const int id : {1, 3}) without.keep(id, wall(2), at(5 * id - 4.6));
    const auto graph = moved_by(0.4, three_walls());
    map.correct(graph);  // space and planes are made anew with all three
    map.follow({{1, graph.at(1)}, {3, graph.at(3)}});
    EXPECT_TRUE(map.has(2));
    for (LiveMap* of : {&map, &without}) of->keep(4, wall(2), at(15.4));
    EXPECT_FALSE(map.has(2));
    map.settle();
    expect_same_layers(map, without);
    for (LiveMap* of : {&map, &without})
      of->follow(moved_by(0.2, {{1, graph.at(1)}, {3, graph.at(3)}, {4, at(15.4).T_map_camera}}));
    map.settle();
    expect_same_layers(map, without);
  }
}

TEST(LiveMap, FramesBetweenKeyframesHangOnThoseThatStay) {
  LiveMapSettings settings = waiting();
  settings.occupancy.max_keyframes = 3;
  LiveMap map(some_camera(), settings);
  map.keep(1, wall(2), at(0));
  map.keep(2, wall(2), at(0.01));
  map.add(wall(2), at(3));  // of keyframe 2
  map.follow({{1, at(0.4).T_map_camera}});
  map.add(wall(2), at(6.4));
  for (const int id : {3, 4}) map.keep(id, wall(2), at(0.4));
  EXPECT_FALSE(map.has(2));
  map.follow({{1, at(0.8).T_map_camera}, {3, at(0.8).T_map_camera}, {4, at(0.8).T_map_camera}});
  const auto vertices = map.settled_mesh().vertices;
  double farthest = 0;
  bool first = false;
  for (const Eigen::Vector3f& v : vertices) {
    farthest = std::max(farthest, static_cast<double>(v.x()));
    first = first || std::abs(v.x() - 5.8F) < 0.05F;
  }
  EXPECT_TRUE(first);
  EXPECT_NEAR(farthest, 8.8, 0.05);
}

TEST(LiveMap, AGraphThatLacksTheMostTakesNothing) {
  LiveMap map(some_camera(), waiting());
  keep_walls(map, {1, 2, 3});
  map.follow({{2, at(5.4).T_map_camera}});
  map.follow({});
  for (const double x : {2.0, 7.4, 12.0}) EXPECT_EQ(state(map, x), CellState::occupied) << x;
}

TEST(LiveMap, WhatIsAdoptedNoGraphTakesAway) {
  LiveMap map(some_camera(), waiting());
  keep_walls(map, {1, 2, 3});
  map.adopt(1000, wall(2), at(15));
  ColouredCloud cloud;
  for (float y = -1; y <= 1; y += 0.02F)
    for (float x = -1; x <= 1; x += 0.02F) cloud.points.emplace_back(x, y, 2.02F);
  cloud.colours.resize(cloud.points.size());
  map.adopt(1001, cloud, at(20).T_map_camera);
  map.follow({{1, at(0.4).T_map_camera}, {2, at(5.4).T_map_camera}});
  for (const double x : {2.4, 7.4, 12.4, 17.0, 22.02}) EXPECT_EQ(state(map, x), CellState::occupied) << x;
}

}  // namespace
}  // namespace lcmslam
