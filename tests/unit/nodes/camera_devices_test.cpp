// The camera process with cameras that follow a script, recordings in their place, and another driver's
// channel.

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>
#include <thread>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/status_t.hpp>
#include "procs/camera/camera_node.hpp"
#include "procs/camera/drivers/device_source.hpp"
#include "procs/camera/live_source.hpp"
#include "tests/support/written_head.hpp"
#include "tests/unit/runtime/capturing_publisher.hpp"

namespace lcmslam {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using testing::largest_difference;
using testing::numbered_colour;
using testing::numbered_depth;

const cv::Size colour_size{160, 120}, depth_size{80, 60};

double value_of(const NodeReport& report, const std::string& name) {
  for (const auto& [key, value] : report.values)
    if (key == name) return value;
  ADD_FAILURE() << "no value " << name;
  return -1;
}

class CameraDevices : public ::testing::Test {
 protected:
  CameraDevices() { testing::write_head(folder / "head.yaml", colour_size, depth_size); }

  CameraNode& start(const std::string& config) {
    node.reset();
    node = std::make_unique<CameraNode>(ConfigNode::parse(config, (folder / "robot.yaml").string()),
                                        publisher, make_source_or_device);
    node->connect(inputs);
    return *node;
  }
  void run_to_the_end() {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (node->report().state != status_t::FINISHED && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::min<Node::Duration>(*node->work(), milliseconds(5)));
    ASSERT_EQ(node->report().state, status_t::FINISHED) << node->report().detail;
  }
  std::string refusal(const std::string& config) {
    try {
      start(config);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  testing::TemporaryFolder folder;
  testing::CapturingPublisher publisher;
  Inputs inputs;
  std::unique_ptr<CameraNode> node;
};

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
  std::string config(const std::string& tolerance) const {
    return "{source: pair, pair: {tolerance: " + tolerance +
           ", colour: {video: {start: 1000, rate: 30, file: " + (folder / "colour%03d.png").string() +
           "}}, depth: {video: {start: 1000.006, rate: 10, file: " + (folder / "depth%03d.png").string() +
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
  EXPECT_EQ(value_of(node->report(), "malformed_frames"), 1);
}

/// Gives images at a pace by the real clock, until it is unplugged.
class PacedCamera : public CameraDevice {
 public:
  PacedCamera(bool depth, Utime period, const std::atomic<bool>& plugged, int& number,
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
  int& number_;  // goes on when it is opened again
};

TEST_F(CameraDevices, OfAPairOneMayBeUnpluggedAndIsNamed) {
  std::atomic<bool> colour{true}, depth{true};
  int colours = 0, depths = 0;
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
  depth = true;
  EXPECT_TRUE(wait_for(""));
  std::thread stopper([&] { source.stop(); });
  while (source.next()) {
  }
  stopper.join();
}

TEST_F(CameraDevices, APairIsOfOneMomentByDepthsClock) {
  constexpr Utime ahead = 250'000;  // us
  const std::atomic<bool> plugged{true};
  int colours = 0, depths = 0;
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

// ------------------------------------------------------------- another driver's channel

class ForeignDriver : public CameraDevices {
 protected:
  /// As openni2-camera-lcm publishes: nobody numbers the messages, or names the sensor.
  images_t foreign(int number, ImageCoding colour_coding, bool raw_depth) const {
    RgbdFrame frame;
    frame.utime = frame.depth_utime = 5'000'000 + number * 33'000;
    frame.colour = numbered_colour(colour_size, number);
    frame.depth = numbered_depth(depth_size, number);
    EncodedFrame encoded = encode(frame, 95);
    if (colour_coding != ImageCoding::jpeg) {
      cv::Mat pixels = frame.colour;
      if (colour_coding == ImageCoding::raw_rgb) {
        pixels = pixels.clone();
        pixels.forEach<cv::Vec3b>([](cv::Vec3b& p, const int*) { std::swap(p[0], p[2]); });
      }
      if (colour_coding == ImageCoding::raw_gray) cv::extractChannel(frame.colour, pixels, 1);
      encoded.colour.coding = colour_coding;
      encoded.colour.bytes.assign(pixels.data, pixels.data + pixels.total() * pixels.elemSize());
    }
    if (raw_depth) {
      encoded.depth.coding = ImageCoding::depth_raw;
      encoded.depth.bytes.assign(frame.depth.data, frame.depth.data + 2 * frame.depth.total());
    }
    images_t message = to_message(encoded);
    for (image_t& image : message.images) {
      image.metadata.clear();
      image.nmetadata = 0;
    }
    return message;
  }
  void deliver(const images_t& message) {
    const auto bytes = encode_message(message);
    ASSERT_TRUE(inputs.deliver("OPENNI_FRAME", bytes.data(), bytes.size()));
  }
  CameraNode& start_relay() {
    return start("{source: channel, live: {calibration: head.yaml, watch: {late_after: 0.05}}}");
  }
};

TEST_F(ForeignDriver, ItsImagesBecomeCameraWhateverTheirCoding) {
  start_relay();
  node->work();
  int number = 0;
  for (const auto coding :
       {ImageCoding::jpeg, ImageCoding::raw_rgb, ImageCoding::raw_bgr, ImageCoding::raw_gray})
    for (const bool raw_depth : {false, true}) {
      deliver(foreign(++number, coding, raw_depth));
      const auto messages = publisher.on<images_t>("CAMERA");
      ASSERT_EQ(messages.size(), static_cast<std::size_t>(number));
      const images_t& message = messages.back();
      EXPECT_EQ(origin(message).seq, number - 1);
      EXPECT_EQ(origin(message).sender, publisher.sender());
      EXPECT_EQ(message.images[0].pixelformat, image_t::PIXEL_FORMAT_MJPEG) << "raw images are too big";
      EXPECT_EQ(message.image_types[1], images_t::DEPTH_MM_ZIPPED);
      const RgbdFrame frame = decode_images(message, load_calibration(folder / "head.yaml"));
      EXPECT_EQ(frame.sensor, "mine");
      EXPECT_EQ(frame.utime, 5'000'000 + number * 33'000);
      EXPECT_EQ(largest_difference(frame.depth, numbered_depth(depth_size, number)), 0);
      if (coding != ImageCoding::raw_gray) {
        EXPECT_LT(largest_difference(frame.colour, numbered_colour(colour_size, number)), 16);
      }
    }
  EXPECT_EQ(publisher.on<camera_calibration_t>("CAMERA_CALIBRATION").size(), 1U);
  EXPECT_EQ(node->report().detail, "");
  EXPECT_EQ(value_of(node->report(), "relayed"), 8);
}

TEST_F(ForeignDriver, RowsThatAreLongerThanTheirPixelsAreTakenApart) {
  start_relay();
  images_t message = foreign(1, ImageCoding::raw_bgr, true);
  for (image_t& image : message.images) {
    const auto row = static_cast<std::size_t>(image.row_stride), stride = row + 24;
    std::vector<std::uint8_t> padded;
    for (int v = 0; v < image.height; ++v) {
      padded.insert(padded.end(), image.data.begin() + static_cast<std::ptrdiff_t>(row) * v,
                    image.data.begin() + static_cast<std::ptrdiff_t>(row) * (v + 1));
      padded.resize(stride * (static_cast<std::size_t>(v) + 1), 0xaa);
    }
    image.data = padded;
    image.size = static_cast<int>(padded.size());
    image.row_stride = static_cast<int>(stride);
  }
  deliver(message);
  const auto messages = publisher.on<images_t>("CAMERA");
  ASSERT_EQ(messages.size(), 1U) << node->report().detail;
  const RgbdFrame frame = decode_images(messages[0], load_calibration(folder / "head.yaml"));
  EXPECT_EQ(largest_difference(frame.depth, numbered_depth(depth_size, 1)), 0);
  EXPECT_LT(largest_difference(frame.colour, numbered_colour(colour_size, 1)), 16);
}

TEST_F(ForeignDriver, WhatIsNoImageOfThisHeadIsRefusedAndTold) {
  start_relay();
  images_t wrong = foreign(1, ImageCoding::jpeg, false);
  wrong.images[0].width = 999;
  deliver(wrong);
  EXPECT_THAT(node->report().detail,
              HasSubstr("the colour image is 999x120, by its calibration it must be 160x120"));
  images_t lying = foreign(1, ImageCoding::jpeg, false);
  lying.images[0].data =
      encode(RgbdFrame{0, 0, 0, "", numbered_colour({32, 24}, 1), numbered_depth(depth_size, 1), {}})
          .colour.bytes;
  lying.images[0].size = static_cast<int>(lying.images[0].data.size());
  deliver(lying);
  EXPECT_THAT(node->report().detail, HasSubstr("its JPEG is 32x24"));
  images_t without = foreign(1, ImageCoding::jpeg, false);
  without.image_types[1] = 55;
  deliver(without);
  EXPECT_THAT(node->report().detail, HasSubstr("no depth image"));
  images_t short_one = foreign(1, ImageCoding::raw_rgb, false);
  short_one.images[0].data.pop_back();
  short_one.images[0].size -= 1;
  deliver(short_one);
  EXPECT_THAT(node->report().detail, HasSubstr("bytes"));
  EXPECT_TRUE(publisher.on<images_t>("CAMERA").empty());
  EXPECT_EQ(value_of(node->report(), "refused"), 4);
  deliver(foreign(2, ImageCoding::jpeg, false));
  EXPECT_EQ(node->report().detail, "");
}

TEST_F(ForeignDriver, ImagesWithoutAnyStampGetTheirArrivals) {
  start_relay();
  images_t message = foreign(1, ImageCoding::jpeg, false);
  message.utime = message.images[0].utime = message.images[1].utime = 0;
  deliver(message);
  const auto messages = publisher.on<images_t>("CAMERA");
  ASSERT_EQ(messages.size(), 1U);
  using namespace std::chrono;
  const auto now = duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
  EXPECT_NEAR(static_cast<double>(messages[0].utime), static_cast<double>(now), 5e6);
  EXPECT_EQ(messages[0].images[1].utime, messages[0].utime);
}

TEST_F(ForeignDriver, DamagedBytesAreCountedAndNeverFatal) {
  start_relay();
  Random random(3);
  std::int64_t delivered = 0;
  for (const auto coding : {ImageCoding::jpeg, ImageCoding::raw_rgb})
    for (const bool raw_depth : {false, true}) {
      const auto whole = encode_message(foreign(1, coding, raw_depth));
      for (int i = 0; i < 200; ++i) {
        auto bytes = whole;
        // Among the fields before the pixels, and anywhere.
        const auto limit = i % 2 == 0 ? std::min<std::size_t>(bytes.size(), 80) : bytes.size();
        for (int flips = 0; flips < 3; ++flips)
          bytes[static_cast<std::size_t>(random.uniform(0, 0.999) * static_cast<double>(limit))] =
              static_cast<std::uint8_t>(random.uniform(0, 255));
        if (i % 10 == 9) bytes.resize(bytes.size() / 2);
        inputs.deliver("OPENNI_FRAME", bytes.data(), bytes.size());
        ++delivered;
      }
    }
  const NodeReport report = node->report();
  const auto errors = static_cast<double>(inputs.all().back()->decode_errors);
  EXPECT_EQ(value_of(report, "relayed") + value_of(report, "refused") + errors, delivered);
  EXPECT_GT(value_of(report, "refused"), 10);
  EXPECT_GT(errors, 10);
}

TEST_F(ForeignDriver, ItsSilenceIsTold) {
  start_relay();
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  while (node->report().detail.empty() && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(milliseconds(5));
  EXPECT_THAT(node->report().detail, HasSubstr("OPENNI_FRAME: no image for 0."));
}

}  // namespace
}  // namespace lcmslam
