// The camera process with cameras that follow a script, and recordings in their place.

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>
#include <thread>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/status_t.hpp>
#include "procs/camera/live_source.hpp"
#include "tests/unit/nodes/camera_devices_fixture.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

using std::chrono::milliseconds;
using testing::CameraDevices;
using testing::colour_size;
using testing::depth_size;
using ::testing::HasSubstr;
using testing::largest_difference;
using testing::numbered_colour;
using testing::numbered_depth;
using testing::reported;

/// A colour camera of 30 Hz and a depth camera of 10 Hz that stamps 6 ms later, as images that lie in a
/// folder.
class PairOfRecordings : public CameraDevices {
 protected:
  void SetUp() override {
    for (int i = 0; i < 30; ++i) write("colour", i, numbered_colour(colour_size, i));
    for (int i = 0; i < 10; ++i) write("depth", i, numbered_depth(depth_size, i));
  }
  void write(const std::string& kind, int number, const cv::Mat& image) {
    char name[32];
    std::snprintf(name, sizeof name, "%s%03d.png", kind.c_str(), number);
    cv::imwrite((folder / name).string(), image);
  }
  std::string config(const std::string& tolerance, const std::string& colour_start = "1000",
                     const std::string& depth_start = "1000.006") const {
    return "{source: pair, pair: {tolerance: " + tolerance + ", colour: {video: {start: " + colour_start +
           ", rate: 30, file: " + (folder / "colour%03d.png").string() +
           "}}, depth: {video: {start: " + depth_start +
           ", rate: 10, file: " + (folder / "depth%03d.png").string() +
           "}}}, live: {calibration: head.yaml, jpeg_quality: 100}, speed: 5}";
  }
};

TEST_F(PairOfRecordings, IsPlayedAsShotsOfOneMoment) {
  start(config("0.015"));
  run_to_the_end();
  const auto messages = publisher.on<images_t>("CAMERA");
  ASSERT_EQ(messages.size(), 10U);
  const RgbdCalibration calibration =
      from_message(publisher.on<camera_calibration_t>("CAMERA_CALIBRATION").at(0));
  for (int i = 0; i < 10; ++i) {
    const RgbdFrame frame = decode_images(messages[static_cast<std::size_t>(i)], calibration);
    EXPECT_EQ(frame.utime, 1'000'000'000 + i * 100'000) << i;
    EXPECT_EQ(frame.depth_utime, 1'000'006'000 + i * 100'000) << i;
    EXPECT_EQ(largest_difference(frame.depth, numbered_depth(depth_size, i)), 0) << i;
    EXPECT_LT(largest_difference(frame.colour, numbered_colour(colour_size, 3 * i)), 10) << i;
  }
}

TEST_F(PairOfRecordings, WithoutStartBeginTogether) {
  start(config("0.015", "0", "0"));
  run_to_the_end();
  const auto messages = publisher.on<images_t>("CAMERA");
  ASSERT_EQ(messages.size(), 10U);
  for (const images_t& message : messages)
    EXPECT_EQ(message.images[1].utime, message.images[0].utime);  // 3 ms of opening the second one before
  EXPECT_THAT(refusal(config("0.015", "1000", "0")), HasSubstr("depth.start is missing"));
  EXPECT_THAT(refusal(config("0.015", "0", "1000")), HasSubstr("colour.start is missing"));
}

TEST_F(PairOfRecordings, ThatAreTooFarApartGiveNothing) {
  start(config("0.005"));
  run_to_the_end();
  EXPECT_TRUE(publisher.on<images_t>("CAMERA").empty());
}

TEST_F(CameraDevices, WhatIsConfiguredWronglyIsNamed) {
  EXPECT_THAT(refusal("{source: video, video: {file: none.mp4}, live: {calibration: head.yaml}}"),
              HasSubstr("none.mp4"));
  EXPECT_THAT(refusal("{source: video, live: {calibration: nohead.yaml}}"), HasSubstr("nohead.yaml"));
  EXPECT_THAT(refusal("{source: video}"), HasSubstr("calibration"));
  EXPECT_THAT(refusal("{source: channel, channel: {channel: CAMERA}, live: {calibration: head.yaml}}"),
              HasSubstr("another channel than CAMERA"));
  EXPECT_THAT(
      refusal("{source: pair, pair: {depth: {video: {file: x.avi}}}, live: {calibration: head.yaml}}"),
      HasSubstr("two cameras or two recordings"));
  testing::write_head(folder / "registered.yaml", colour_size);
  EXPECT_THAT(refusal("{source: pair, live: {calibration: registered.yaml}}"), HasSubstr("depth_registered"));
}

TEST_F(CameraDevices, ImagesOfAnotherSizeInARecordingAreCountedAsMalformed) {
  for (int i = 0; i < 6; ++i)
    cv::imwrite((folder / ("c" + std::to_string(i) + ".png")).string(),
                numbered_colour(i == 2 ? cv::Size(40, 30) : colour_size, i));
  start("{source: video, video: {start: 5, file: " + (folder / "c%01d.png").string() +
        "}, live: {calibration: head.yaml}}");
  run_to_the_end();
  EXPECT_EQ(publisher.on<images_t>("CAMERA").size(), 5U);
  EXPECT_EQ(reported(node->report(), "malformed_frames"), 1);
}

/// Gives images at a pace by the real clock, until it is unplugged.
class PacedCamera : public CameraDevice {
 public:
  PacedCamera(bool depth, Utime period, const std::atomic<bool>& plugged, std::atomic<int>& number,
              Utime start = 1'000'000)
      : depth_(depth), period_(period), start_(start), plugged_(plugged), number_(number) {
    if (!plugged) throw CameraError("nothing is plugged in");
  }
  std::optional<CameraShot> read(milliseconds) override {
    if (!plugged_) throw CameraError("pulled out");
    std::this_thread::sleep_for(std::chrono::microseconds(period_ / 4));
    RgbdFrame frame;
    frame.utime = frame.depth_utime = start_ + ++number_ * period_;
    (depth_ ? frame.depth : frame.colour) =
        depth_ ? numbered_depth(depth_size, number_) : numbered_colour(colour_size, number_);
    return frame;
  }
  std::string describe() const override { return "paced"; }

 private:
  bool depth_;
  Utime period_, start_;
  const std::atomic<bool>& plugged_;
  std::atomic<int>& number_;  // goes on when it is opened again
};

TEST_F(CameraDevices, OfAPairOneMayBeUnpluggedAndIsNamed) {
  std::atomic<bool> colour{true}, depth{true};
  std::atomic<int> colours{0}, depths{0};
  LiveSettings settings;
  settings.watch.retry_after = 0.05;
  std::vector<WatchedPart> parts = {
      {"colour",
       [&] { return std::make_unique<PacedCamera>(false, 33'333, colour, colours); },
       {colour_size, {}}},
      {"depth",
       [&] { return std::make_unique<PacedCamera>(true, 100'000, depth, depths); },
       {{}, depth_size}}};
  LiveSource source(load_calibration(folder / "head.yaml"), std::move(parts), 15'000, settings);
  for (int i = 0; i < 5; ++i) {
    const auto event = source.next();
    ASSERT_TRUE(event);
    const auto& frame = std::get<EncodedFrame>(*event);
    EXPECT_LE(std::abs(frame.utime - frame.depth.utime), 15'000);
    EXPECT_EQ(frame.sensor, "mine");
  }
  EXPECT_EQ(source.health().trouble, "");
  const auto wait_for = [&](const std::string& text) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (std::chrono::steady_clock::now() < end) {
      const std::string trouble = source.health().trouble;
      if (text.empty() ? trouble.empty() : trouble.find(text) != std::string::npos) return true;
      std::this_thread::sleep_for(milliseconds(2));
    }
    return false;
  };
  depth = false;
  EXPECT_TRUE(wait_for("depth: nothing is plugged in"));
  const auto next_is_blind = [&] {
    const auto event = source.next();
    if (!event) return false;
    const auto& frame = std::get<EncodedFrame>(*event);
    EXPECT_LE(std::abs(frame.utime - frame.depth.utime), 15'000);
    return cv::countNonZero(decode_depth(frame.depth)) == 0;
  };
  const auto blind_ones = [&] {
    double count = 0;
    for (const auto& [name, value] : source.health().values)
      if (name == "without_depth") count = value;
    return count;
  };
  ASSERT_TRUE(testing::wait_for([&] { return blind_ones() > 0; })) << "colour goes on";
  bool blind = false;
  for (int i = 0; i < 20 && !blind; ++i) blind = next_is_blind();  // pairs may wait before it
  EXPECT_TRUE(blind);
  depths = colours / 3;  // its clock went on
  depth = true;
  EXPECT_TRUE(wait_for(""));
  for (int i = 0; i < 20 && blind; ++i) blind = next_is_blind();
  EXPECT_FALSE(blind) << "pairs go on";
  std::thread stopper([&] { source.stop(); });
  while (source.next()) {
  }
  stopper.join();
}

TEST_F(CameraDevices, APairIsOfOneMomentByDepthsClock) {
  constexpr Utime ahead = 250'000;  // us
  const std::atomic<bool> plugged{true};
  std::atomic<int> colours{0}, depths{0};
  std::vector<WatchedPart> parts = {
      {"colour",
       [&] { return std::make_unique<PacedCamera>(false, 100'000, plugged, colours); },
       {colour_size, {}}},
      {"depth",
       [&] { return std::make_unique<PacedCamera>(true, 100'000, plugged, depths, 1'004'000 + ahead); },
       {{}, depth_size}}};
  RgbdCalibration calibration = load_calibration(folder / "head.yaml");
  calibration.depth_clock_offset = -1e-6 * static_cast<double>(ahead);
  LiveSource source(calibration, std::move(parts), 15'000, {});
  const auto pairs = [&] {
    for (const auto& [name, value] : source.health().values)
      if (name == "pairs") return value;
    return -1.0;
  };
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (source.health().trouble.empty() && pairs() < 2 && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(milliseconds(2));
  ASSERT_GE(pairs(), 2) << source.health().trouble;
  for (int i = 0; i < 2; ++i) {
    const auto event = source.next();
    ASSERT_TRUE(event);
    const auto& frame = std::get<EncodedFrame>(*event);
    EXPECT_EQ(frame.depth.utime - frame.utime, 4'000 + ahead) << "images keep their own stamps";
  }
}

TEST_F(PairOfRecordings, IsOfOneMomentByDepthsClock) {
  std::ofstream(folder / "head.yaml", std::ios::app) << "depth_clock_offset: 0.2\n";
  start(config("0.015"));
  run_to_the_end();
  const auto messages = publisher.on<images_t>("CAMERA");
  ASSERT_EQ(messages.size(), 8U) << "depth's last two were taken when colour had ended";
  for (const images_t& message : messages)
    EXPECT_EQ(message.images[1].utime - message.images[0].utime, 6'000 - 200'000);
}

}  // namespace
}  // namespace lcmslam
