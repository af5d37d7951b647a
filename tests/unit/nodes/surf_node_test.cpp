#include "procs/surf/surf_node.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include "tests/support/simulated_kitchen.hpp"
#include "tests/unit/messages/wire_sample.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using testing::SimulatedKitchen;

/// The same shot at another time.
images_t later(images_t message, Utime us) {
  message.utime += us;
  for (image_t& image : message.images) image.utime += us;
  return message;
}

class SurfNodeTest : public ::testing::Test {
 protected:
  SimulatedKitchen& kitchen_ = SimulatedKitchen::instance();
  testing::TestBus bus_;
  SurfNode& node_ = bus_.add<SurfNode>();
};

TEST_F(SurfNodeTest, FrameWaitsForTheCalibrationAndThenGivesFeatures) {
  bus_.deliver("CAMERA", kitchen_.frame(0));
  bus_.deliver("CAMERA", kitchen_.frame(1));
  EXPECT_TRUE(bus_.published().empty());
  EXPECT_THAT(node_.report().detail, HasSubstr("CAMERA_CALIBRATION"));
  bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  const auto features = bus_.on<features_t>("FEATURES");
  ASSERT_EQ(features.size(), 1U);  // of the newest frame that waited
  EXPECT_EQ(features[0].utime, kitchen_.frame_time(1));
  EXPECT_EQ(features[0].frame_seq, 1);
  EXPECT_EQ(node_.report().detail, "");
  bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  EXPECT_EQ(bus_.count("FEATURES"), 1U);
}

TEST_F(SurfNodeTest, WarmingUpIsNotSeenInTheFeatures) {
  testing::TestBus waiting;  // its image was there first
  waiting.add<SurfNode>();
  waiting.deliver("CAMERA", kitchen_.frame(0));
  waiting.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  EXPECT_EQ(bus_.count("FEATURES"), 0U);
  bus_.deliver("CAMERA", kitchen_.frame(0));
  const auto expected = waiting.on<features_t>("FEATURES"), found = bus_.on<features_t>("FEATURES");
  ASSERT_EQ(expected.size(), 1U);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(encode_message(found[0]), encode_message(expected[0]));
}

TEST_F(SurfNodeTest, SecondCameraIsLeftOutWithItsCalibration) {
  bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  bus_.deliver("CAMERA", kitchen_.frame(0));
  camera_calibration_t calibration = kitchen_.calibration();
  calibration.sender = 2000;
  calibration.colour.width /= 2;
  bus_.deliver("CAMERA_CALIBRATION", calibration);
  images_t other = kitchen_.frame(1);
  set_origin(other, {0, 2000});
  bus_.deliver("CAMERA", other);
  EXPECT_EQ(bus_.count("FEATURES"), 1U);
  bus_.deliver("CAMERA", kitchen_.frame(2));
  EXPECT_EQ(bus_.count("FEATURES"), 2U);
  EXPECT_EQ(bus_.stamps(0).foreign(), 1);
  EXPECT_EQ(bus_.decode_errors(), 0);
}

TEST_F(SurfNodeTest, FeaturesBesideEdgesOfDepthAreLeftOut) {
  SurfNode& all = bus_.add<SurfNode>(ConfigNode::parse("largest_depth_step: 1000", "test"));
  SurfNode& few = bus_.add<SurfNode>(ConfigNode::parse("least_features: 100", "test"));
  bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  bus_.deliver("CAMERA", kitchen_.frame(0));
  ASSERT_EQ(bus_.count("FEATURES"), 3U);
  EXPECT_EQ(testing::value_of(all, "straddling"), 0);
  EXPECT_GT(testing::value_of(few, "straddling"), 20);
  EXPECT_EQ(testing::value_of(few, "keypoints") + testing::value_of(few, "straddling"),
            testing::value_of(all, "keypoints"));
}

TEST_F(SurfNodeTest, PointsLieOnTheScene) {
  bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  bus_.deliver("CAMERA", kitchen_.frame(0));
  const FeatureFrame frame = from_message(bus_.on<features_t>("FEATURES").at(0));
  const Eigen::Isometry3d T_world_camera =
      kitchen_.simulation().T_world_robot(frame.utime) * kitchen_.simulation().calibration().T_robot_camera;
  std::vector<double> distances;
  for (const Feature& f : frame.features)
    if (f.kind == MeasurementKind::point)
      distances.push_back(kitchen_.simulation().distance_to_surface(T_world_camera * f.point.cast<double>()));
  ASSERT_GT(distances.size(), 50U);
  EXPECT_EQ(testing::value_of(node_, "with_depth"), static_cast<double>(distances.size()));
  std::sort(distances.begin(), distances.end());
  EXPECT_LT(distances[distances.size() / 2], 0.02);  // ToF noise and wiggle
}

// Surfaces so dark at such ranges may as well lie a turn of the camera's phase farther.
TEST_F(SurfNodeTest, FeaturesLoseDepthsThatMayBeFolded) {
  SurfNode& believes = bus_.add<SurfNode>(ConfigNode::parse("drop_folded: false", "test"));
  EncodedFrame dark = from_message(kitchen_.frame(0));
  const cv::Mat amplitude(dark.depth.height, dark.depth.width, CV_8UC1, cv::Scalar(2));
  dark.amplitude = encode_amplitude(amplitude, dark.depth.utime);
  images_t message = to_message(dark);
  set_origin(message, {0, 1000});
  bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  bus_.deliver("CAMERA", message);
  ASSERT_EQ(bus_.count("FEATURES"), 2U);
  EXPECT_GT(testing::value_of(believes, "with_depth"), 100);
  EXPECT_LT(testing::value_of(node_, "with_depth"), 10);
  EXPECT_GT(testing::value_of(node_, "keypoints"), 100);  // as bearings
}

// As the robot looks around, what the depth camera errs by is learned, and depths are told to be surer.
TEST_F(SurfNodeTest, DepthsGrowSurerAsTheCamerasErrorIsLearned) {
  const auto best_sigma = [&](std::size_t message) {
    std::vector<float> sigmas;
    for (const Feature& f : from_message(bus_.on<features_t>("FEATURES").at(message)).features)
      if (f.kind == MeasurementKind::point) sigmas.push_back(f.depth_sigma);
    EXPECT_GT(sigmas.size(), 50U);
    std::sort(sigmas.begin(), sigmas.end());
    return sigmas[sigmas.size() / 50];  // most lie on corners, where depths differ by more
  };
  bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  for (int i = 0; i < 120; i += 3) bus_.deliver("CAMERA", kitchen_.frame(i));
  EXPECT_LT(best_sigma(bus_.count("FEATURES") - 1), 0.9F * best_sigma(0));
}

double mean_x(const features_t& message) {
  double sum = 0;
  int points = 0;
  for (const Feature& f : from_message(message).features)
    if (f.kind == MeasurementKind::point) sum += f.point.x(), ++points;
  EXPECT_GT(points, 50);
  return sum / points;
}

TEST_F(SurfNodeTest, AChangedCalibrationIsTakenOver) {
  camera_calibration_t calibration = kitchen_.calibration();
  bus_.deliver("CAMERA_CALIBRATION", calibration);
  bus_.deliver("CAMERA", kitchen_.frame(0));
  calibration.colour.cx -= 50;  // pixels
  bus_.deliver("CAMERA_CALIBRATION", calibration);
  bus_.deliver("CAMERA", later(kitchen_.frame(0), 100'000));
  const auto features = bus_.on<features_t>("FEATURES");
  ASSERT_EQ(features.size(), 2U);
  EXPECT_NEAR(from_message(features[1]).cx, calibration.colour.cx, 1e-6);
  EXPECT_GT(std::abs(mean_x(features[1]) - mean_x(features[0])), 0.02);
}

// It is made of these features: what it errs by would come back.
TEST_F(SurfNodeTest, DepthImagesAreMovedByWheelsAndNotByVisualOdometry) {
  const auto mean_with = [&](const std::string& source) {
    testing::TestBus bus;
    bus.add<SurfNode>();
    bus.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
    images_t frame = kitchen_.frame(0);
    for (image_t& image : frame.images)  // the depth image is of 15 ms later
      if (image.pixelformat != image_t::PIXEL_FORMAT_MJPEG) image.utime = frame.utime + 15'000;
    for (int i = 0; i < 3; ++i) {
      const Utime utime = frame.utime + (i - 1) * 50'000;
      MotionSample sample;
      sample.utime = utime;
      sample.T_odom_robot = planar_pose(0, 0, 2 * i * 0.05);
      if (!source.empty()) bus.deliver("ODOMETRY", to_message(sample, source));
    }
    bus.deliver("CAMERA", frame);
    const auto features = bus.on<features_t>("FEATURES");
    EXPECT_EQ(features.size(), 1U);
    return features.empty() ? 0 : mean_x(features.front());
  };
  const double still = mean_with("");
  EXPECT_GT(std::abs(mean_with("wheels") - still), 0.005);
  EXPECT_EQ(mean_with("visual"), still);
}

TEST_F(SurfNodeTest, BadImageBytesAreCountedAndTheNextFrameIsUsed) {
  bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  std::int64_t errors = 0;
  const auto expect_refused = [&](auto change) {
    images_t message = later(kitchen_.frame(0), 10'000 * errors);
    change(message);
    bus_.deliver("CAMERA", message);
    EXPECT_EQ(bus_.input(0, "CAMERA").decode_errors, ++errors);
    EXPECT_EQ(bus_.count("FEATURES"), 0U);
  };
  expect_refused([](images_t& m) { m.images[0].data.resize(100), m.images[0].size = 100; });
  expect_refused([](images_t& m) { m.images[1].data.assign(10, 7), m.images[1].size = 10; });
  expect_refused([](images_t& m) { m.images[1].width -= 1; });
  expect_refused([](images_t& m) { m.images[1].utime += 10'000'000; });  // no shot of one moment
  expect_refused([](images_t& m) {  // sound, but not of the calibration's size
    m.images[1].width = m.images[1].height = 2;
    m.images[1].data = encode_depth(cv::Mat::ones(2, 2, CV_16UC1), 0).bytes;
    m.images[1].size = static_cast<int32_t>(m.images[1].data.size());
  });
  bus_.deliver("CAMERA", kitchen_.frame(1));
  EXPECT_EQ(bus_.count("FEATURES"), 1U);
}

/// Kitchen images with their colour changed.
images_t changed(images_t message, const std::function<void(cv::Mat&)>& change) {
  cv::Mat image = cv::imdecode(message.images[0].data, cv::IMREAD_COLOR);
  change(image);
  cv::imencode(".jpg", image, message.images[0].data);
  message.images[0].size = static_cast<int32_t>(message.images[0].data.size());
  return message;
}

TEST_F(SurfNodeTest, TellsOfBlurAndOfLittleTextureAndGoesOn) {
  bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  bus_.deliver("CAMERA", kitchen_.frame(0));
  EXPECT_EQ(node_.report().detail, "");
  const double sharp = testing::value_of(node_, "sharpness");

  bus_.deliver("CAMERA", changed(kitchen_.frame(1), [](cv::Mat& m) { cv::blur(m, m, {25, 1}); }));
  EXPECT_THAT(node_.report().detail, HasSubstr("blurred"));
  EXPECT_LT(testing::value_of(node_, "sharpness"), 0.6 * sharp);
  EXPECT_EQ(testing::value_of(node_, "blurred_frames"), 1);

  for (int i = 2; i < 10; ++i)  // fades to a plain wall, so that it does not look like blur
    bus_.deliver("CAMERA", changed(later(kitchen_.frame(0), 100'000 * i), [&](cv::Mat& m) {
                   m.convertTo(m, -1, 0);
                   cv::circle(m, {100, 100}, 8, cv::Scalar::all(8), -1);
                 }));
  EXPECT_EQ(bus_.count("FEATURES"), 10U);
  EXPECT_LT(testing::value_of(node_, "threshold"), 100);
  EXPECT_LT(testing::value_of(node_, "keypoints"), 50);
  bus_.deliver("CAMERA", later(kitchen_.frame(3), 1'000'000));
  EXPECT_EQ(node_.report().detail, "");
  EXPECT_GT(testing::value_of(node_, "keypoints"), 100);
}

TEST(SurfNode, LeavesImagesOutAboveItsRate) {
  auto& kitchen = SimulatedKitchen::instance();
  testing::TestBus bus;
  SurfNode& node = bus.add<SurfNode>(ConfigNode::parse("rate: 10", "test"));
  bus.deliver("CAMERA_CALIBRATION", kitchen.calibration());
  for (int i = 0; i < 9; ++i) {
    bus.deliver("CAMERA", later(kitchen.frame(0), 33'333 * i));
  }
  EXPECT_EQ(bus.count("FEATURES"), 3U);
  EXPECT_EQ(testing::value_of(node, "left_out"), 6);
}

// Where the camera's rate is no multiple of it, too.
TEST(SurfNode, IsNeverFasterThanItsRate) {
  auto& kitchen = SimulatedKitchen::instance();
  for (const double rate : {25., 12.}) {
    testing::TestBus bus;
    bus.add<SurfNode>(ConfigNode::parse("{max_features: 20, rate: " + std::to_string(rate) + "}", "test"));
    bus.deliver("CAMERA_CALIBRATION", kitchen.calibration());
    constexpr int images = 60;
    for (int i = 0; i < images; ++i)
      bus.deliver("CAMERA", later(kitchen.frame(0), 33'333 * i + (i % 3 - 1) * 2'000));
    EXPECT_NEAR(static_cast<double>(bus.count("FEATURES")), images / 30. * rate, 2) << rate;
  }
}

TEST(SurfNode, KeepsItsBudgetAndSaysWhichFeaturesHaveNoDepth) {
  auto& kitchen = SimulatedKitchen::instance();
  testing::TestBus bus;
  bus.add<SurfNode>(ConfigNode::parse("max_features: 80", "test"));
  bus.deliver("CAMERA_CALIBRATION", kitchen.calibration());
  bus.deliver("CAMERA", kitchen.frame(0));
  const FeatureFrame frame = from_message(bus.on<features_t>("FEATURES").at(0));
  EXPECT_EQ(frame.features.size(), 80U);
  int bearings = 0;
  for (const Feature& f : frame.features) {
    EXPECT_EQ(f.kind == MeasurementKind::bearing, !f.point.allFinite());
    bearings += f.kind == MeasurementKind::bearing ? 1 : 0;
  }
  EXPECT_GT(bearings, 0);  // the colour camera sees more than the ToF camera
}

TEST_F(SurfNodeTest, MutatedFramesDoNotStopIt) {
  bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  Random random(1);
  const auto good = encode_message(kitchen_.frame(0));
  for (int i = 0; i < 40; ++i) {
    auto bytes = good;
    testing::mutate(bytes, random);
    bus_.deliver("CAMERA", bytes);
  }
  const std::size_t before = bus_.count("FEATURES");
  EXPECT_GT(bus_.decode_errors(), 0);
  bus_.deliver("CAMERA", kitchen_.frame(2));
  EXPECT_EQ(bus_.count("FEATURES"), before + 1);
}

}  // namespace
}  // namespace lcmslam
