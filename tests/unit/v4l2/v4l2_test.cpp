// V4L2 cameras, from the driver's calls to CAMERA.

#include <gmock/gmock.h>

#include <chrono>
#include <thread>

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/status_t.hpp>
#include "procs/camera/camera_node.hpp"
#include "procs/camera/drivers/device_source.hpp"
#include "procs/camera/drivers/open_driver.hpp"
#include "procs/camera/drivers/wall_clock.hpp"
#include "tests/support/written_head.hpp"
#include "tests/unit/runtime/capturing_publisher.hpp"
#include "tests/unit/v4l2/fake_v4l2.hpp"

namespace lcmslam {
namespace {

using std::chrono::milliseconds;
using testing::fake_v4l2;
using testing::FakeV4l2;
using ::testing::HasSubstr;
using testing::largest_difference;

class V4l2 : public ::testing::Test {
 protected:
  void SetUp() override {
    testing::reset_fake_v4l2();
    settings.device = FakeV4l2::name;
    settings.width = 320;
    settings.height = 240;
    settings.rate = 50;
  }
  VideoSettings settings;
};

TEST_F(V4l2, AnImageHasTheStampOfItsCaptureNotOfItsArrival) {
  const auto camera = open_video(settings);
  EXPECT_EQ(fake_v4l2().size, cv::Size(320, 240));
  EXPECT_EQ(fake_v4l2().rate, 50);
  EXPECT_THAT(camera->describe(), HasSubstr("320x240, 50 Hz, BGR3"));
  Utime last = 0;
  for (int i = 0; i < 20; ++i) {
    const auto frame = camera->read(milliseconds(500));
    ASSERT_TRUE(frame) << i;
    using namespace std::chrono;
    const Utime now = duration_cast<microseconds>(steady_clock::now().time_since_epoch()).count();
    const Utime captured = wall_clock() - (now - fake_v4l2().captured);
    EXPECT_NEAR(static_cast<double>(frame->utime), static_cast<double>(captured), 2000);
    EXPECT_EQ(largest_difference(frame->colour, testing::numbered_colour({320, 240}, fake_v4l2().number)), 0);
    if (i > 1) {
      EXPECT_NEAR(static_cast<double>(frame->utime - last), 20'000, 3000) << i;
    }
    last = frame->utime;
  }
}

// The process got no processor for three seconds: what it finds in the buffers is not of now.
TEST_F(V4l2, AnImageThatHasWaitedForLongKeepsItsStamp) {
  const auto camera = open_video(settings);
  ASSERT_TRUE(camera->read(milliseconds(500)));
  fake_v4l2().waited = 3'000'000;
  const auto frame = camera->read(milliseconds(500));
  ASSERT_TRUE(frame);
  EXPECT_NEAR(static_cast<double>(wall_clock() - frame->utime), 3e6, 0.5e6);
}

// NTP sets it: stamps that went back would be refused until it has come after them.
TEST_F(V4l2, StampsRiseWhileTheWallClockIsSetBackABit) {
  const auto camera = open_video(settings);
  Utime last = 0;
  for (int i = 0; i < 60; ++i) {
    if (i == 5) {
      const Utime before = wall_clock();
      testing::wall_clock_set = -500'000;
      ASSERT_LT(wall_clock(), before);
    }
    const auto frame = camera->read(milliseconds(500));
    ASSERT_TRUE(frame);
    EXPECT_GT(frame->utime, last) << i;
    last = frame->utime;
  }
  EXPECT_NEAR(static_cast<double>(wall_clock() - last), 0, 0.1e6) << "it is followed";
}

TEST_F(V4l2, StampsOfAnotherClockAreNotBelieved) {
  fake_v4l2().waited = 3'000'000;  // from the first image on
  const auto camera = open_video(settings);
  const auto frame = camera->read(milliseconds(500));
  ASSERT_TRUE(frame);
  EXPECT_NEAR(static_cast<double>(wall_clock() - frame->utime), 0, 0.5e6);
}

TEST_F(V4l2, TheExposureIsByHandOrAutomatic) {
  settings.exposure = 0.005;
  open_video(settings);
  EXPECT_EQ(fake_v4l2().exposure_mode, 1);
  EXPECT_EQ(fake_v4l2().exposure, 50) << "in steps of 100 us";
  settings.exposure = 0;
  open_video(settings);
  EXPECT_EQ(fake_v4l2().exposure_mode, 3);
  EXPECT_EQ(fake_v4l2().closed, fake_v4l2().opened);
}

TEST_F(V4l2, AFormatThatItLacksIsTold) {
  settings.format = "MJPG";
  EXPECT_THAT(open_video(settings)->describe(), HasSubstr("instead of MJPG"));
}

TEST_F(V4l2, JpegImagesStayAsTheCameraMadeThem) {
  fake_v4l2().has_jpeg = true;
  settings.format = "MJPG";
  const auto camera = open_video(settings);
  EXPECT_THAT(camera->describe(), HasSubstr("MJPG as it is"));
  for (int i = 0; i < 3; ++i) {
    const auto shot = camera->read(milliseconds(500));
    ASSERT_TRUE(shot);
    EXPECT_EQ(shot->jpeg, fake_v4l2().jpeg);
    EXPECT_EQ(shot->jpeg_size, cv::Size(320, 240));
    EXPECT_TRUE(shot->colour.empty());
    EXPECT_EQ(shot->damage, "");
  }
  settings.keep_jpeg = false;
  const auto decoded = open_video(settings)->read(milliseconds(500));
  ASSERT_TRUE(decoded);
  EXPECT_LT(largest_difference(decoded->colour, testing::numbered_colour({320, 240}, fake_v4l2().number)),
            12);
  EXPECT_TRUE(decoded->jpeg.empty());
}

TEST_F(V4l2, AJpegWithoutBytesIsDamagedAndTheCameraGoesOn) {
  fake_v4l2().has_jpeg = true;
  settings.format = "MJPG";
  const auto camera = open_video(settings);
  for (const bool whole : {true, false, false, true}) {
    fake_v4l2().cut_off = whole ? 0 : 1'000'000;
    const auto shot = camera->read(milliseconds(500));
    ASSERT_TRUE(shot);
    EXPECT_EQ(shot->damage.empty(), whole);
    EXPECT_EQ(shot->jpeg.empty(), !whole);
  }
}

TEST_F(V4l2, ADepthCameraGivesItsSixteenBits) {
  settings.images = "depth";
  settings.format = "Y16 ";
  const auto camera = open_video(settings);
  const auto frame = camera->read(milliseconds(500));
  ASSERT_TRUE(frame);
  EXPECT_EQ(largest_difference(frame->depth, testing::numbered_depth({320, 240}, fake_v4l2().number)), 0);
}

TEST_F(V4l2, ASilentCameraIsWaitedForNoLongerThanAskedFor) {
  const auto camera = open_video(settings);
  ASSERT_TRUE(camera->read(milliseconds(500)));
  fake_v4l2().silent = true;
  const auto begin = std::chrono::steady_clock::now();
  while (camera->read(milliseconds(100))) {
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, milliseconds(1000));
}

TEST_F(V4l2, AnUnpluggedCameraIsAnErrorThatNamesIt) {
  const auto camera = open_video(settings);
  ASSERT_TRUE(camera->read(milliseconds(500)));
  fake_v4l2().plugged = false;
  EXPECT_THROW(
      {
        for (int i = 0; i < 3; ++i) camera->read(milliseconds(100));
      },
      CameraError);
  try {
    open_video(settings);
    ADD_FAILURE();
  } catch (const CameraError& error) {
    EXPECT_THAT(error.what(), HasSubstr(FakeV4l2::name));
  }
}

/// The camera process on such a camera.
class V4l2Node : public V4l2 {
 protected:
  void start(cv::Size size, const std::string& more = "") {
    testing::write_head(folder / "head.yaml", size);
    const std::string config = "{source: video, video: {device: " + std::string(FakeV4l2::name) +
                               ", width: 320, height: 240, rate: 50" + more +
                               "}, live: {calibration: head.yaml, watch: " + "{retry_after: 0.1}}}";
    node = std::make_unique<CameraNode>(ConfigNode::parse(config, (folder / "robot.yaml").string()),
                                        publisher, make_source_or_device);
  }
  /// Works until what is asked for is so.
  bool wait_for(const std::function<bool()>& is_so, double seconds = 10) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
      node->work();
      if (is_so()) return true;
      std::this_thread::sleep_for(milliseconds(2));
    }
    return false;
  }
  std::size_t sent() const { return publisher.on<images_t>("CAMERA").size(); }

  testing::TemporaryFolder folder;
  testing::CapturingPublisher publisher;
  std::unique_ptr<CameraNode> node;
};

TEST_F(V4l2Node, PublishesTheImagesWithTheirCalibrationAndADepthThatMeasuredNothing) {
  start({320, 240});
  ASSERT_TRUE(wait_for([&] { return sent() >= 10; }));
  EXPECT_EQ(node->report().state, status_t::RUNNING);
  EXPECT_EQ(node->report().detail, "");
  const auto calibrations = publisher.on<camera_calibration_t>("CAMERA_CALIBRATION");
  ASSERT_FALSE(calibrations.empty());
  const RgbdCalibration calibration = from_message(calibrations[0]);
  EXPECT_EQ(calibration.sensor, "mine");
  Utime last = 0;
  for (const images_t& message : publisher.on<images_t>("CAMERA")) {
    const RgbdFrame frame = decode_images(message, calibration);
    EXPECT_GT(frame.utime, last);
    last = frame.utime;
    EXPECT_EQ(cv::countNonZero(frame.depth), 0);
    EXPECT_EQ(frame.depth.size(), cv::Size(320, 240));
    EXPECT_EQ(frame.sensor, "mine");
  }
  EXPECT_NEAR(static_cast<double>(last), static_cast<double>(wall_clock()), 0.5e6);
}

TEST_F(V4l2Node, ACameraThatIsUnpluggedIsToldWithinASecondAndComesBack) {
  fake_v4l2().plugged = false;
  start({320, 240});
  ASSERT_TRUE(wait_for([&] { return !node->report().detail.empty(); }));
  EXPECT_THAT(node->report().detail, HasSubstr(FakeV4l2::name));
  EXPECT_EQ(node->report().state, status_t::STARTING);
  fake_v4l2().plugged = true;
  ASSERT_TRUE(wait_for([&] { return sent() >= 5; }));
  EXPECT_EQ(node->report().state, status_t::RUNNING);
  fake_v4l2().plugged = false;
  EXPECT_TRUE(wait_for([&] { return node->report().detail.find("is tried again") != std::string::npos; }, 1));
  EXPECT_EQ(node->report().state, status_t::STARTING) << "a change of state goes out at once";
  fake_v4l2().plugged = true;
  const auto before = sent();
  ASSERT_TRUE(wait_for([&] { return sent() >= before + 5; }));
  EXPECT_TRUE(wait_for([&] { return node->report().detail.empty(); }));
  EXPECT_EQ(node->report().state, status_t::RUNNING);
  fake_v4l2().silent = true;
  EXPECT_TRUE(
      wait_for([&] { return node->report().detail.find("no image for 0.") != std::string::npos; }, 1));
  EXPECT_EQ(node->report().state, status_t::STARTING);
}

TEST_F(V4l2Node, PublishesTheCamerasOwnJpegAndCountsWhatIsCutOff) {
  fake_v4l2().has_jpeg = true;
  start({320, 240}, ", format: MJPG");
  ASSERT_TRUE(wait_for([&] { return sent() >= 5; }));
  bool the_last_is_there = false;  // the camera goes on meanwhile
  ASSERT_TRUE(wait_for([&] {
    const auto message = publisher.on<images_t>("CAMERA").back();
    the_last_is_there = std::equal(message.images[0].data.begin(), message.images[0].data.end(),
                                   fake_v4l2().jpeg.begin(), fake_v4l2().jpeg.end());
    return the_last_is_there;
  }));
  EXPECT_EQ(publisher.on<images_t>("CAMERA").back().images[0].pixelformat, image_t::PIXEL_FORMAT_MJPEG);

  fake_v4l2().cut_off = 100;
  ASSERT_TRUE(wait_for([&] { return node->report().detail.find("cut off") != std::string::npos; }));
  const auto before = sent();
  const auto refused = [&] {
    for (const auto& [name, value] : node->report().values)
      if (name == "refused") return value;
    return 0.0;
  };
  const double refused_before = refused();
  EXPECT_TRUE(wait_for([&] { return refused() > refused_before + 3; }));
  EXPECT_EQ(sent(), before);
  fake_v4l2().cut_off = 0;
  EXPECT_TRUE(wait_for([&] { return sent() > before + 3; }));
}

// OpenCV would take 640x480.
TEST_F(V4l2Node, ACameraIsAskedForTheCalibrationsSize) {
  testing::write_head(folder / "head.yaml", {800, 600});
  const std::string config =
      "{source: video, video: {device: " + std::string(FakeV4l2::name) + "}, live: {calibration: head.yaml}}";
  node = std::make_unique<CameraNode>(ConfigNode::parse(config, (folder / "robot.yaml").string()), publisher,
                                      make_source_or_device);
  EXPECT_TRUE(wait_for([&] { return sent() >= 1; })) << node->report().detail;
  EXPECT_EQ(fake_v4l2().size, cv::Size(800, 600));
}

// OpenCV passes over one alone.
TEST_F(V4l2Node, WidthAndHeightAreNamedTogether) {
  const std::string config = "{source: video, video: {width: 800}, live: {calibration: head.yaml}}";
  try {
    CameraNode::read(ConfigNode::parse(config, (folder / "robot.yaml").string()));
    ADD_FAILURE();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("height"));
  }
}

TEST_F(V4l2Node, ImagesOfAnotherSizeThanTheCalibrationsAreRefusedAndTold) {
  fake_v4l2().only_size = {160, 120};
  start({320, 240});
  ASSERT_TRUE(wait_for([&] { return node->report().detail.find("160x120") != std::string::npos; }));
  EXPECT_EQ(sent(), 0U);
}

}  // namespace
}  // namespace lcmslam
