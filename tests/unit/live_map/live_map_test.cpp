#include <lcmslam/live_map/live_map.hpp>

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <utility>

#include <lcmslam/live_map/answer.hpp>

#include "tests/support/wiggling_camera.hpp"
#include "tests/unit/live_map/seen_walls.hpp"

namespace lcmslam {
namespace {

TEST(LiveMap, FramesBetweenKeyframesMoveWithThem) {
  LiveMap map(some_camera(), waiting());
  map.keep(7, wall(2), at(0));
  map.add(wall(1.8), at(0.2));
  EXPECT_NEAR(mean_x(map.mesh()), 2, 0.02);
  map.correct({{7, at(0.4).T_map_camera}});
  while (map.improve()) {
  }
  EXPECT_NEAR(mean_x(map.mesh()), 2.4, 0.02);
}

TEST(LiveMap, FramesWhereTheRobotCameBackMoveWithWhatIsThere) {
  LiveMap map(some_camera(), waiting());
  map.keep(7, wall(2), at(0));
  map.keep(8, wall(2), at(20));
  map.add(wall(1.8), at(0.2));
  map.correct({{7, at(0.4).T_map_camera}, {8, at(20).T_map_camera}});
  const Mesh mesh = map.settled_mesh();
  int beside = 0;
  for (const Eigen::Vector3f& v : mesh.vertices)
    beside += v.x() < 10 && std::abs(v.x() - 2.4f) > 0.1f ? 1 : 0;
  EXPECT_EQ(beside, 0) << "of " << mesh.vertices.size();
}

// The robot has come back to where no new keyframe is made: a frame sees a wall that none saw, before a
// correction, and another while space is carved anew.
TEST(LiveMap, WhatFramesSawMovesWithTheNearestKeyframe) {
  for (const bool background : {false, true}) {
    LiveMapSettings settings = waiting();
    settings.background = background;
    LiveMap map(some_camera(), settings);
    map.keep(4, wall(4), at(0));
    map.keep(5, wall(4), at(20));
    map.adopt(1, wall(4), at(0));  // of another drive
    for (int i = 0; i < 4; ++i) map.show(wall(2), at(0));
    map.correct({{4, at(0.4).T_map_camera}, {5, at(20).T_map_camera}});
    for (int i = 0; i < 4; ++i) map.show(wall(1.2), at(0.4));
    map.settle();
    EXPECT_EQ(state(map, 2.4), CellState::occupied) << background;
    EXPECT_EQ(state(map, 1.6), CellState::occupied) << background;
    map.correct({{4, at(0.8).T_map_camera}, {5, at(20).T_map_camera}});
    map.settle();
    EXPECT_EQ(state(map, 2.8), CellState::occupied) << background;
    EXPECT_EQ(state(map, 2.0), CellState::occupied) << background;
    EXPECT_NE(state(map, 2.4), CellState::occupied) << background;
  }
}

// Somebody steps in the way while the server shows what it has of yesterday, where nobody stood.
TEST(LiveMap, WhatWasSeenBeforeIsNoNewsOfWhatStandsInTheWay) {
  LiveMap map(some_camera(), waiting());
  for (int i = 0; i < 6; ++i) map.show(wall(2), at(0));
  map.show(wall(1.2), at(0));
  map.adopt(1000, wall(2), at(0));
  map.keep(5, wall(2), at(0), LiveMap::When::before);
  const auto newest = [&] {
    return map.space().ask([](const LiveSpace::View& view) {
      return view.newest.sample({1, 0, 1}).distance;
    });
  };
  EXPECT_NEAR(newest(), 0.2, 0.05);
  map.keep(6, wall(2), at(0));
  EXPECT_GT(newest(), 0.4) << "he has gone";
}

// A building that was mapped before has more keyframes than there is room for.
TEST(LiveMap, AdoptedKeyframesMakeRoomForTheMapsOwn) {
  LiveMapSettings settings = waiting();
  settings.occupancy.max_keyframes = 10;
  LiveMap map(some_camera(), settings);
  map.keep(1, wall(2), at(0));
  for (int i = 0; i < 30; ++i) map.adopt(1000 + i, wall(2), at(100));
  EXPECT_TRUE(map.has(1));
  EXPECT_TRUE(map.has(1029)) << "the newest of them";
  for (int own = 2; own <= 10; ++own) map.keep(own, wall(2), at(10 * own));
  for (int i = 0; i < 30; ++i) EXPECT_FALSE(map.has(1000 + i)) << i;
  map.adopt(2000, wall(2), at(100));
  EXPECT_FALSE(map.has(2000)) << "there is no room";
  std::map<int, Eigen::Isometry3d> moved;
  for (int own = 1; own <= 10; ++own) moved[own] = at((own > 1 ? 10 * own : 0) + 0.4).T_map_camera;
  map.correct(moved);
  map.settle();
  EXPECT_EQ(state(map, 2.4), CellState::occupied) << "the first is still known";
  EXPECT_EQ(state(map, 102.4), CellState::occupied);
}

// Whoever draws the surface asks whether anything is new.
TEST(LiveMap, EveryChangeOfTheSurfaceCounts) {
  LiveMap map(some_camera(), waiting());
  map.keep(7, wall(2), at(0));
  std::int64_t version = map.version();
  map.add(wall(1.8), at(0.2));
  EXPECT_GT(map.version(), std::exchange(version, map.version()));
  map.mesh();
  map.correct({{7, at(0.4).T_map_camera}});
  version = map.version();
  map.improve();
  EXPECT_GT(map.version(), version);
}

double distance_at_1(const LiveMap& map) {
  return map.space().ask([](const LiveSpace::View& view) {
    return view.distances.field().sample({1, 0, 1}).distance;
  });
}

TEST(LiveMap, DistancesFollowEveryThirdFrameAndEachKeyframe) {
  LiveMap shown(some_camera(), waiting()), kept(some_camera(), waiting());
  EXPECT_EQ(distance_at_1(shown), 2);  // somebody asks: from now on they follow
  EXPECT_EQ(distance_at_1(kept), 2);
  shown.show(wall(2), at(0));
  shown.show(wall(2), at(0));
  EXPECT_EQ(distance_at_1(shown), 2);  // nothing near
  shown.show(wall(2), at(0));
  EXPECT_NEAR(distance_at_1(shown), 1, 0.05);
  kept.keep(1, wall(2), at(0));
  EXPECT_NEAR(distance_at_1(kept), 1, 0.05);
}

// Nobody asked for more than `distance_rest` frames: the next answer is nevertheless of what is there by now,
// around where the robot is by now.
TEST(LiveMap, DistancesThatRestedAreBroughtUpToDate) {
  LiveMapSettings settings = waiting();
  settings.distance_rest = 2;
  settings.distance.memory = 1;
  LiveMap map(some_camera(), settings), asked(some_camera(), settings);
  EXPECT_EQ(distance_at_1(map), 2);
  const auto covered_at = [](const LiveMap& of, double x) {
    return of.space().ask([&](const LiveSpace::View& view) {
      return view.distances.covers({Eigen::Vector3d(x, 0, 1), Eigen::Vector3d(x, 0, 1)});
    });
  };
  for (double x = 0; x <= 40; x += 2)
    for (int i = 0; i < 3; ++i)
      for (LiveMap* each : {&map, &asked}) {
        each->show(wall(2), at(x));
        if (each == &asked) distance_at_1(asked);
      }
  const auto distance_at_41 = [](const LiveSpace::View& view) {
    return view.distances.field().sample({41, 0, 1}).distance;
  };
  EXPECT_TRUE(covered_at(map, 41));
  EXPECT_FALSE(covered_at(map, 1));
  EXPECT_NEAR(map.space().ask(distance_at_41), 1, 0.05);
  EXPECT_EQ(map.space().ask(distance_at_41), asked.space().ask(distance_at_41));
}

TEST(LiveMap, WhoStepsInTheWayCountsAtOnce) {
  LiveMap map(some_camera(), waiting());
  for (int i = 0; i < 6; ++i) map.show(wall(2), at(0));
  EXPECT_NEAR(distance_at_1(map), 1, 0.05);
  map.show(wall(1.2), at(0));
  EXPECT_NEAR(distance_at_1(map), 1, 0.05);
  EXPECT_NEAR(map.space().ask([](const LiveSpace::View& v) {
    return v.newest.sample({1, 0, 1}).distance;
  }),
              0.2, 0.05);
}

TEST(LiveMap, AKeyframeWithoutImagesGivesSpaceByItsCloud) {
  ColouredCloud cloud;
  for (float y = -1; y <= 1; y += 0.02F)
    for (float x = -1; x <= 1; x += 0.02F) cloud.points.emplace_back(x, y, 2.02F);
  cloud.colours.resize(cloud.points.size());
  const cv::Mat depth = depth_of_cloud(cloud, some_camera().depth);
  EXPECT_EQ(depth.at<std::uint16_t>(60, 80), 2020);
  LiveMap map(some_camera(), waiting());
  map.keep(3, cloud, at(0).T_map_camera);
  EXPECT_TRUE(map.has(3));
  EXPECT_EQ(state(map, 2.02), CellState::occupied);
  EXPECT_EQ(state(map, 1), CellState::free);
  EXPECT_TRUE(map.mesh().vertices.empty());
}

nlohmann::json answered(const std::shared_ptr<const LiveMap>& map, const std::string& question) {
  AskedMap asked;
  asked.live = map;
  return nlohmann::json::parse(answer(parse_question(question), asked).bytes);
}

/// Walls 2 m ahead along a way of 40 m, of which distances are kept around its end.
std::shared_ptr<LiveMap> long_way() {
  LiveMapSettings settings = waiting();
  settings.distance.memory = 1;
  auto map = std::make_shared<LiveMap>(some_camera(), settings);
  for (double x = 0; x <= 40; x += 2)  // through all, as if the walls had not been there
    for (int i = 0; i < 3; ++i) map->show(wall(2), at(x));
  return map;
}

TEST(LiveMap, WhoAsksFarFromTheRobotIsAnsweredAsNearIt) {
  const auto map = std::make_shared<LiveMap>(some_camera(), waiting());
  for (int i = 0; i < 3; ++i) map->show(wall(2), at(0));
  const auto there = answered(map, R"({"ask": "distance", "points": [[1, 0, 1], [1.5, 0, 1]]})");
  const auto way = long_way();
  const bool covered = way->space().ask([](const LiveSpace::View& view) {
    return view.distances.covers({Eigen::Vector3d(1, 0, 1), Eigen::Vector3d(1, 0, 1)});
  });
  EXPECT_FALSE(covered);
  const auto far = answered(way, R"({"ask": "distance", "points": [[1, 0, 1], [41, 0, 1], [1.5, 0, 1]]})");
  EXPECT_EQ(far["distances"][0], there["distances"][0]);
  EXPECT_NEAR(far["distances"][1], 1, 0.05);
  EXPECT_EQ(far["distances"][2], there["distances"][1]);
  EXPECT_EQ(far["truncation"], waiting().distance.truncation);
  const std::string spheres =
      R"({"ask": "collision", "spheres": [[1.5, 0, 1, 0.6], [41.5, 0, 1, 0.6], [1.5, 0, 1, 0.4]]})";
  EXPECT_EQ(answered(way, spheres)["collides"], nlohmann::json({true, true, false}));
}

TEST(LiveMap, TheFirstPoseThatCollidesIsTheFirstWhereverItIs) {
  const auto path = [](const std::string& poses) {
    return R"({"ask": "path", "robot": [0, 0, 1, 1, 0, 0, 0, 0.4, 0.4, 0.4], "poses": [)" + poses + "]}";
  };
  const auto map = long_way();
  // At the robot, then far: what is near is looked at first, and the far one is nevertheless found.
  EXPECT_EQ(answered(map, path("[41, 0, 0, 0], [2, 0, 0, 0], [42, 0, 0, 0]"))["first_collision"], 1);
  EXPECT_EQ(
      answered(map, path("[41, 0, 0, 0], [1, 0, 0, 0], [42, 0, 0, 0], [2, 0, 0, 0]"))["first_collision"], 2);
  EXPECT_TRUE(answered(map, path("[41, 0, 0, 0], [1, 0, 0, 0]"))["free"]);
}

TEST(LiveMap, PlacesFarFromTheRobotAreMadeUntilTheDeadlineAndEachOnce) {
  AskedMap asked;
  asked.live = long_way();
  int looks = 0, most = 1000;
  asked.is_late = [&] { return ++looks > most; };
  // Two places, to and fro between them, and one that is near.
  const auto question = parse_question(
      R"({"ask": "distance", "points": [[1, 0, 1], [11, 0, 1], [1.5, 0, 1], [11.5, 0, 1], [41, 0, 1]]})");
  answer(question, asked);
  EXPECT_EQ(looks, 5 + 2);  // for each place, and before each time that distances are made
  looks = 0;
  most = 4;
  try {
    answer(question, asked);
    ADD_FAILURE() << "answered after its deadline";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("2 of its 5 places"));
  }
}

TEST(LiveMap, PlacesNearTheRobotAreAskedUntilTheDeadline) {
  AskedMap asked;
  asked.live = long_way();
  int looks = 0;
  asked.is_late = [&] { return ++looks > 2; };
  const auto question =
      parse_question(R"({"ask": "distance", "points": [[41, 0, 1], [41, 0, 1], [41, 0, 1], [41, 0, 1]]})");
  EXPECT_THAT([&] { answer(question, asked); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("2 of its 4 places")));
}

// A body that is longer than what distances are kept for stands near the robot and far from it.
TEST(LiveMap, WhoStepsInTheWayOfALongBodyCountsAtOnce) {
  const auto map = long_way();
  for (int i = 0; i < 6; ++i) map->show(wall(2), at(40));  // so that one frame does not change the kept map
  const std::string across = R"({"ask": "collision", "capsules": [[41.2, -1, 1, 41.2, 28, 1, 0.1]]})";
  EXPECT_EQ(answered(map, across)["collides"][0], false);
  RgbdFrame somebody = wall(2);
  somebody.depth(cv::Rect(60, 40, 40, 40)).setTo(1200);  // where all has been seen to be free
  map->show(somebody, at(40));
  EXPECT_EQ(answered(map, across)["collides"][0], true);
}

TEST(LiveMap, KeyframesAreWorkedInOnce) {
  LiveMap map(some_camera(), waiting());
  map.keep(1, wall(2), at(0));
  const std::int64_t version = map.version();
  map.keep(1, wall(1), at(0));
  EXPECT_EQ(map.version(), version);
}

TEST(LiveMap, WhatIsMadeBesideIsTheSameWhenItIsDone) {
  LiveMapSettings beside = waiting();
  beside.background = true;
  LiveMap slow(some_camera(), beside), waited(some_camera(), waiting());
  for (LiveMap* map : {&slow, &waited}) {
    map->keep(1, wall(2), at(0));
    map->keep(2, wall(2.1), at(-0.1));
    map->correct({{1, at(0.3).T_map_camera}, {2, at(0.2).T_map_camera}});
    map->settle();
  }
  for (double x = 0.1; x < 3; x += 0.04) EXPECT_EQ(state(slow, x), state(waited, x)) << x;
  EXPECT_EQ(slow.planes().size(), waited.planes().size());
}

/// How far the worst of the planes that a drive's last keyframes show is from the corridor's, m.
double worst_of_the_corridors_planes(bool learns, bool another_camera_looks) {
  LiveMapSettings settings = waiting();
  settings.range_error.enabled = learns;
  const auto camera = std::make_shared<RgbdCalibration>(testing_scene::tof_camera()),
             another = std::make_shared<RgbdCalibration>(some_camera());
  const testing_scene::Scene corridor = testing_scene::corridor();
  LiveMap map(camera, settings);
  Random random(1);
  constexpr int images = 25, last = 20;
  for (int i = 0; i < images; ++i) {
    RgbdFrame frame;
    frame.utime = frame.depth_utime = 400'000 * i;
    const FramePose pose{testing_scene::view(0.15 * i, 0.2 * std::sin(0.3 * i), 0.4 * std::sin(0.5 * i)),
                         Eigen::Isometry3d::Identity()};
    frame.depth =
        testing_scene::measured(corridor, *camera, pose.T_map_camera, testing_scene::wiggle, random);
    frame.colour = cv::Mat(frame.depth.size(), CV_8UC3, cv::Scalar(50, 100, 150));
    i < last ? map.show(frame, pose) : map.keep(i, frame, pose);
    if (!another_camera_looks) continue;
    map.look_through(another);
    map.show(wall(2), at(100));
    map.look_through(camera);
  }
  double most = 0;
  for (const PlanePatch& patch : map.planes()) {
    double nearest = 1;
    for (const auto& plane : corridor.planes)
      if (plane.normal.cross(patch.fit.plane.normal).norm() < 0.1)
        nearest = std::min(nearest, std::abs(plane.normal.dot(patch.fit.centre) - plane.offset));
    most = std::max(most, nearest);
  }
  return most;
}

TEST(LiveMap, TheDepthCamerasErrorIsLearnedAndTakenAway) {
  EXPECT_GT(worst_of_the_corridors_planes(false, false), 0.003);
  EXPECT_LT(worst_of_the_corridors_planes(true, false), 0.001);
  EXPECT_LT(worst_of_the_corridors_planes(true, true), 0.001);
}

}  // namespace
}  // namespace lcmslam
