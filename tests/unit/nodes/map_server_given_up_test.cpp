// What the mapper gives up, heard or not, is no place any more, and moves with what stays in all that is
// derived from it; and nothing else goes.

#include "tests/unit/nodes/map_server_places_fixture.hpp"

namespace lcmslam {
namespace {

using testing::first_number;
using testing::Life;
using testing::seen_view;
using testing::SeenView;
using testing::views_of_room;

const Eigen::Isometry3d as_it_was = Eigen::Isometry3d::Identity();

class MapServerGivenUp : public testing::MapServerPlaces {
 protected:
  static void hear(Life& server) {
    const SeenView& next = seen_view(first_number + 3);
    server.track(next.features.utime, next.T_world_camera);
  }
  std::size_t stored(std::size_t session) const {
    MapFile map(file());
    return map.keyframes(map.sessions().at(session).id).size();
  }
};

TEST_F(MapServerGivenUp, MovesWithTheRestInWhatIsDerived) {
  Life server(scratch_.path(), "map", 3, "{background: false}");
  server.drive(first_number, as_it_was);
  server.give_up({2});  // the graph is not known whole yet
  server.correct(first_number, as_it_was, {2});
  server.give_up({1, 4});
  const std::size_t before = server.derived()->cloud(0.03).size();
  server.correct(first_number, elsewhere(), {1, 2, 4});
  for (int id = 0; id < views_of_room; ++id) EXPECT_TRUE(server.derived()->has(id)) << id;
  const ColouredCloud cloud = server.derived()->cloud(0.03);
  EXPECT_GT(cloud.size(), before * 9 / 10);
  std::size_t in_place = 0;
  for (const Eigen::Vector3f& point : cloud.points) {
    const Eigen::Vector3d in_kitchen = elsewhere().inverse() * point.cast<double>();
    const auto& kitchen = testing::SimulatedKitchen::instance().simulation();
    in_place += std::abs(kitchen.distance_to_surface(in_kitchen)) < 0.05 ? 1 : 0;
  }
  EXPECT_GT(in_place, cloud.size() * 97 / 100) << cloud.size();
}

TEST_F(MapServerGivenUp, WhileAMessageWasMissedItIsNoPlaceAnyMore) {
  Life server(scratch_.path(), "map", 3);
  server.drive(first_number, as_it_was);
  EXPECT_EQ(server.value("places"), views_of_room);
  server.correct(first_number, as_it_was, {1, 4});
  EXPECT_EQ(server.value("places"), views_of_room - 2);
}

TEST_F(MapServerGivenUp, ByAGraphThatLacksTheMostNothingGoes) {
  Life server(scratch_.path(), "map", 3, "{background: false}");
  server.drive(first_number, as_it_was);
  server.give_up({0, 1, 2, 3});
  EXPECT_EQ(server.value("places"), views_of_room);
  server.correct(first_number, as_it_was, {1, 2, 3, 4});
  EXPECT_EQ(server.value("places"), views_of_room);
  server.correct(first_number, as_it_was);
  EXPECT_EQ(server.value("places"), views_of_room);
}

TEST_F(MapServerGivenUp, WhileTheServerWasDownItIsNoPlaceAnyMore) {
  for (const bool graph_first : {false, true}) {
    std::filesystem::remove(file());
    map_once();
    {
      Life server(scratch_.path(), "map", 3);
      if (graph_first) server.correct(first_number, as_it_was, {1, 4});
      hear(server);
      if (!graph_first) {
        EXPECT_EQ(server.value("kept_keyframes"), views_of_room);
        server.correct(first_number, as_it_was, {1, 4});
      }
      EXPECT_EQ(server.value("kept_keyframes"), views_of_room - 2) << graph_first;
      server.finish();
    }
    EXPECT_EQ(stored(0), views_of_room - 2U) << graph_first;
  }
}

TEST_F(MapServerGivenUp, ByAGraphThatIsNotWholeNothingElseGoes) {
  map_once();
  Life server(scratch_.path(), "map", 3);
  hear(server);
  server.give_up({4});
  EXPECT_EQ(server.value("kept_keyframes"), views_of_room - 1);
}

// Its sessions are of the past, whatever another mapper has.
TEST_F(MapServerGivenUp, ByAnotherMapperNothingOfTheFileGoes) {
  map_once();
  Life server(scratch_.path(), "map", 33);
  server.correct(first_number, as_it_was, {1, 4});
  hear(server);
  server.correct(first_number, as_it_was, {1, 4});
  EXPECT_EQ(server.value("kept_keyframes"), views_of_room);
  server.finish();
  EXPECT_EQ(stored(0), static_cast<std::size_t>(views_of_room));
}

TEST_F(MapServerGivenUp, AGraphThatLacksTheMostLeavesTheFilesPlacesWhereTheyAre) {
  map_once();
  Life server(scratch_.path(), "map", 3);
  hear(server);
  server.correct(first_number, as_it_was, {0, 1, 2, 3, 4});
  EXPECT_EQ(server.value("kept_keyframes"), views_of_room);
  server.correct(first_number, elsewhere(), {1});  // the session that was left does not follow any more
  EXPECT_EQ(server.value("kept_keyframes"), views_of_room);
  server.look(first_number + 2);
  EXPECT_EQ(server.localise()["found"], true);
  expect_near(pose_of(server.localise()["camera"]), seen_view(first_number + 2).T_world_camera);
  server.finish();
  EXPECT_EQ(stored(0), static_cast<std::size_t>(views_of_room));
}

}  // namespace
}  // namespace lcmslam
