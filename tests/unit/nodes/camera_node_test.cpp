// The camera process beside another driver's images: it publishes their calibration, and nothing else.

#include "procs/camera/camera_node.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/status_t.hpp>
#include "tests/support/recordings.hpp"
#include "tests/unit/runtime/capturing_publisher.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

/// Of the kitchen's own camera.
images_t recorded_images() {
  LogReader log(own_log("kitchen.lcmlog"));
  while (const auto event = log.next())
    if (event->channel == "CAMERA") return decode_message<images_t>(event->data.data(), event->data.size());
  throw std::runtime_error("no CAMERA in the log");
}

class CalibrationSource : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "lcmslam-camera-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    const images_t images = recorded_images();
    write("head.yaml", images.images[0], images.images[1]);
    write("wrong.yaml", images.images[1], images.images[1]);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const image_t& colour, const image_t& depth) const {
    const auto camera = [](const image_t& image) {
      return "{width: " + std::to_string(image.width) + ", height: " + std::to_string(image.height) +
             ", fx: 200, fy: 200, cx: 80, cy: 70}\n";
    };
    std::ofstream(folder_ / name) << "sensor: mine\ncolour: " << camera(colour) << "depth: " << camera(depth)
                                  << "colour_depth: {translation: [0, 0, 0], quaternion: [1, 0, 0, 0]}\n";
  }

  /// A node whose configuration lies beside the calibration and names it as `file`.
  CameraNode& start(const std::string& file) {
    const std::string config = "{source: calibration, calibration: {file: " + file + "}}";
    node_ = std::make_unique<CameraNode>(ConfigNode::parse(config, (folder_ / "robot.yaml").string()),
                                         publisher_);
    node_->connect(inputs_);
    return *node_;
  }

  std::filesystem::path folder_;
  testing::CapturingPublisher publisher_{5};
  Inputs inputs_;
  std::unique_ptr<CameraNode> node_;
};

TEST_F(CalibrationSource, IsPublishedForAsLongAsTheProcessRuns) {
  CameraNode& node = start("head.yaml");
  node.work();
  node.work();  // less than a second later
  ASSERT_EQ(publisher_.all.size(), 1U);
  EXPECT_EQ(publisher_.all[0].channel, "CAMERA_CALIBRATION");
  const auto& bytes = publisher_.all[0].bytes;
  EXPECT_EQ(decode_message<camera_calibration_t>(bytes.data(), bytes.size()).sensor, "mine");
  EXPECT_EQ(node.report().state, status_t::RUNNING);
  const auto wait = node.work();
  ASSERT_TRUE(wait);
  EXPECT_LE(*wait, std::chrono::seconds(1)) << "the next calibration is never sent";
}

// A second without calibration is a second without features for who was killed and started again.
TEST_F(CalibrationSource, IsToldAtOnceToWhoHasJustStarted) {
  using Clock = std::chrono::steady_clock;
  CameraNode& node = start("head.yaml");
  node.work();
  const auto calibrations_after = [&](double uptime) {
    publisher_.all.clear();
    status_t status{};
    status.process = "surf";
    status.uptime = uptime;
    const auto bytes = encode_message(status);
    EXPECT_TRUE(inputs_.deliver("STATUS", bytes.data(), bytes.size()));
    const auto end = Clock::now() + std::chrono::milliseconds(300);
    while (publisher_.all.empty() && Clock::now() < end) {
      const auto wait = node.work();
      std::this_thread::sleep_for(std::min<Node::Duration>(*wait, std::chrono::milliseconds(10)));
    }
    return publisher_.all.size();
  };
  EXPECT_EQ(calibrations_after(60), 0U);
  EXPECT_EQ(calibrations_after(0.01), 1U);
}

TEST_F(CalibrationSource, SaysWhenTheImagesAreNotOfTheCalibration) {
  const auto images = encode_message(recorded_images());
  CameraNode& fitting = start("head.yaml");
  inputs_.deliver("CAMERA", images.data(), images.size());
  EXPECT_EQ(fitting.report().detail, "calibration for another driver's CAMERA");
  inputs_ = Inputs();
  CameraNode& wrong = start("wrong.yaml");
  inputs_.deliver("CAMERA", images.data(), images.size());
  EXPECT_THAT(wrong.report().detail,
              HasSubstr("the colour image is 640x480, by its calibration it must be 176x144"));
}

TEST_F(CalibrationSource, AFileThatIsNotThereIsNamed) {
  try {
    start("none.yaml");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr((folder_ / "none.yaml").string()));
  }
}

}  // namespace
}  // namespace lcmslam
