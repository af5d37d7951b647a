// A camera that is calibrated anew: what was kept before is not read by what holds now.

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/decode.hpp>
#include "procs/map-server/layer_feed.hpp"
#include "procs/map-server/map_recorder.hpp"
#include "tests/unit/nodes/map_server_places_fixture.hpp"

namespace lcmslam {
namespace {

using testing::first_number;
using testing::frames_between;
using testing::Life;
using testing::MapServerPlaces;
using testing::SimulatedKitchen;
using testing::views_of_room;

camera_calibration_t with_other_optics() {
  RgbdCalibration calibration = SimulatedKitchen::instance().simulation().calibration();
  calibration.depth.fx *= 1.1;
  camera_calibration_t message = to_message(calibration);
  message.sender = SimulatedKitchen::instance().calibration().sender;
  return message;
}

camera_calibration_t with_other_mount() {
  RgbdCalibration calibration = SimulatedKitchen::instance().simulation().calibration();
  calibration.T_robot_camera.translation().z() += 0.1;
  camera_calibration_t message = to_message(calibration);
  message.sender = SimulatedKitchen::instance().calibration().sender;
  return message;
}

class MapServerCameras : public MapServerPlaces {
 protected:
  static constexpr const char* layers = "{background: false, rate: 0}";
  /// The bytes of the calibration of a keyframe's images.
  std::vector<std::uint8_t> camera_of(std::int64_t session, std::int32_t keyframe) {
    const auto images = MapFile(file()).images(session, keyframe);
    return images && images->calibration ? images->calibration->bytes : std::vector<std::uint8_t>();
  }
  /// A life beside the map of an earlier one, whose keyframes it shows, under a calibration.
  std::pair<double, double> kept_and_imageless(const camera_calibration_t& calibration) {
    {
      Life first(scratch_.path(), "map", 3, layers);
      first.drive(first_number, Eigen::Isometry3d::Identity());
      first.finish();
    }
    Life server(scratch_.path(), "map", 13, layers);
    server.calibrate(calibration);
    server.drive(first_number + 2, elsewhere());
    EXPECT_EQ(server.value("sessions_joined"), 1);
    const std::pair counts(server.value("layer_keyframes"), server.value("layer_imageless"));
    server.finish();
    return counts;
  }
};

TEST_F(MapServerCameras, ImagesKeepTheCalibrationOfTheirTime) {
  Life server(scratch_.path(), "map", 3, layers);
  server.drive(first_number, Eigen::Isometry3d::Identity());
  server.calibrate(with_other_optics());
  camera_calibration_t second_camera = with_other_mount();  // of the same name
  second_camera.sender = 77;
  server.calibrate(second_camera);
  server.goes_on_from(views_of_room);
  server.drive(first_number + views_of_room * frames_between, Eigen::Isometry3d::Identity());
  server.finish();
  const auto before = stored(SimulatedKitchen::instance().calibration()).bytes,
             after = stored(with_other_optics()).bytes;
  ASSERT_NE(before, after);
  for (int id = 0; id < views_of_room; ++id) {
    EXPECT_EQ(camera_of(1, id), before) << id;
    EXPECT_EQ(camera_of(1, views_of_room + id), after) << id;
  }
}

TEST_F(MapServerCameras, ImagesOfTheOldMapAreShownByTheirOwn) {
  EXPECT_EQ(kept_and_imageless(with_other_optics()), std::pair(2.0 * views_of_room, 0.0));
  EXPECT_EQ(camera_of(1, 0), stored(SimulatedKitchen::instance().calibration()).bytes);
  EXPECT_EQ(camera_of(2, 0), stored(with_other_optics()).bytes);
}

TEST_F(MapServerCameras, AnotherMountIsNoOtherCamera) {
  EXPECT_EQ(kept_and_imageless(with_other_mount()), std::pair(2.0 * views_of_room, 0.0));
}

// The map is what it was; frames by which it grows are read by what holds now.
TEST(LayerFeedCameras, ACameraThatIsCalibratedAnewTakesNothingAway) {
  LayerSettings settings;
  settings.map.background = false;
  LayerFeed feed(settings);
  const RgbdCalibration calibration = SimulatedKitchen::instance().simulation().calibration();
  feed.calibrate(calibration);
  const auto show = [&](int id, const EncodedFrame& frame) {
    feed.camera(frame);
    DenseKeyframe keyframe;
    keyframe.id = id;
    keyframe.utime = frame.utime;
    EXPECT_TRUE(feed.keyframe(keyframe));
  };
  show(0, from_message(SimulatedKitchen::instance().frame(first_number)));
  RgbdCalibration anew = calibration;
  anew.depth.fx *= 1.1;
  feed.calibrate(anew);
  EXPECT_EQ(feed.newest_image(), nullptr) << "taken by the other";
  EXPECT_TRUE(feed.map()->has(0));
  const std::size_t before = feed.map()->cloud(0.03).size();
  show(1, from_message(SimulatedKitchen::instance().frame(first_number + 40)));
  EXPECT_GT(feed.map()->cloud(0.03).size(), before * 11 / 10);
  EXPECT_EQ(feed.state().failed, 0) << feed.state().error;
}

// Its mapper lived on while the server was restarted, and the camera was calibrated meanwhile.
TEST(LayerFeedCameras, KeyframesAreReadByTheCalibrationOfTheirTime) {
  LayerSettings settings;
  settings.map.background = false;
  LayerFeed feed(settings);
  feed.calibrate(SimulatedKitchen::instance().simulation().calibration());
  StoredImages images;
  images.frame = from_message(SimulatedKitchen::instance().frame(first_number));
  images.frame.amplitude = {};
  DenseKeyframe keyframe;
  keyframe.cloud.points = {{0, 0, 1}};
  keyframe.cloud.colours.resize(1);
  const auto show = [&](int id) {
    keyframe.id = id;
    EXPECT_FALSE(feed.keyframe(keyframe, [&] { return images; }));
  };
  show(0);
  EXPECT_EQ(feed.state().imageless, 1) << "nobody knows which";
  images.calibration =
      std::make_shared<StoredCalibration>(stored(SimulatedKitchen::instance().calibration()));
  show(1);
  EXPECT_EQ(feed.state().kept, 1);
  images.calibration = std::make_shared<StoredCalibration>(StoredCalibration{"tof", "form", {1, 2, 3}});
  show(2);
  EXPECT_EQ(feed.state().imageless, 2) << "nobody can read it";
  RgbdCalibration of_its_time = SimulatedKitchen::instance().simulation().calibration();
  const int columns = of_its_time.depth.width / 2;
  const cv::Mat depth = decode_depth(images.frame.depth).colRange(0, columns);
  of_its_time.depth.width = columns;
  images.frame.depth = encode_depth(depth, images.frame.depth.utime);
  images.calibration = std::make_shared<StoredCalibration>(stored(to_message(of_its_time)));
  show(3);
  feed.adopt(1003, Eigen::Isometry3d::Identity(), images, {});
  EXPECT_EQ(feed.state().kept, 3);
  EXPECT_EQ(feed.state().imageless, 2);
  EXPECT_EQ(feed.state().failed, 0) << feed.state().error;
}

}  // namespace
}  // namespace lcmslam
