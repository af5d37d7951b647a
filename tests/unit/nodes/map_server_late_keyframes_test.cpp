// Keyframes that come when there is no time for them are in what is derived all the same.

#include "procs/map-server/layer_feed.hpp"
#include "tests/unit/nodes/map_server_places_fixture.hpp"

namespace lcmslam {
namespace {

using testing::first_number;
using testing::Life;
using testing::SimulatedKitchen;
using testing::views_of_room;

class MapServerLateKeyframes : public testing::MapServerPlaces {
 protected:
  static void expect_all_derived(const Life& server) {
    ASSERT_TRUE(server.derived());
    for (int id = 0; id < views_of_room; ++id) EXPECT_TRUE(server.derived()->has(id)) << id;
  }
};

TEST_F(MapServerLateKeyframes, OfATimeBeforeTheCalibration) {
  Life server(scratch_.path(), "map", 3, "{background: false}", false);
  server.drive(first_number, Eigen::Isometry3d::Identity());
  EXPECT_FALSE(server.derived());
  server.calibrate(SimulatedKitchen::instance().calibration());
  for (int k = 0; k < views_of_room; ++k) server.work();
  expect_all_derived(server);
}

TEST_F(MapServerLateKeyframes, OfATimeBeforeTheirMapsFirstPose) {
  Life server(scratch_.path(), "map", 3, "{background: false}");
  server.poses_come_late();
  server.drive(first_number, Eigen::Isometry3d::Identity());
  expect_all_derived(server);
  server.drive(first_number, Eigen::Isometry3d::Identity(), false, "map1");
  expect_all_derived(server);
}

/// 1 m before the camera.
DenseKeyframe some_cloud(int id) {
  DenseKeyframe keyframe;
  keyframe.id = id;
  keyframe.utime = 1'000'000 * (id + 1);
  keyframe.cloud.points.assign(1000, {0, 0, 1});
  keyframe.cloud.colours.resize(1000);
  return keyframe;
}

TEST(LayerFeedTime, IsThereUntilManyWait) {
  LayerFeed feed(LayerSettings{});
  EXPECT_FALSE(feed.has_time_for(some_cloud(0))) << "no calibration yet";
  feed.calibrate(SimulatedKitchen::instance().simulation().calibration());
  int handed_in = 0;
  while (feed.has_time_for(some_cloud(handed_in)) && handed_in < 10'000)
    feed.keyframe(some_cloud(handed_in++));
  EXPECT_LT(handed_in, 10'000);
  const EncodedFrame frame = from_message(SimulatedKitchen::instance().frame(first_number));
  feed.camera(frame);
  DenseKeyframe seen_now = some_cloud(handed_in);
  seen_now.utime = frame.utime;
  EXPECT_TRUE(feed.has_time_for(seen_now)) << "its images go";
  feed.settle(std::chrono::minutes(5));
  EXPECT_TRUE(feed.has_time_for(some_cloud(handed_in)));
  EXPECT_EQ(feed.state().left_out, 0);
}

}  // namespace
}  // namespace lcmslam
