// The camera process with another driver's channel in the place of its own cameras.

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include "tests/unit/nodes/camera_devices_fixture.hpp"

namespace lcmslam {
namespace {

using testing::CameraDevices;
using testing::colour_size;
using testing::depth_size;
using ::testing::HasSubstr;
using testing::largest_difference;
using testing::numbered_colour;
using testing::numbered_depth;
using testing::reported;

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
  EXPECT_EQ(reported(node->report(), "relayed"), 8);
}

// Whoever reads CAMERA is told neither half an image nor one twice.
TEST_F(ForeignDriver, CutOffImagesAndOldStampsAreRefused) {
  start_relay();
  node->work();
  images_t cut = foreign(1, ImageCoding::jpeg, false);
  cut.images[0].data.resize(cut.images[0].data.size() / 2);
  cut.images[0].size = static_cast<std::int32_t>(cut.images[0].data.size());
  deliver(cut);
  EXPECT_EQ(publisher.on<images_t>("CAMERA").size(), 0U);
  EXPECT_THAT(node->report().detail, HasSubstr("cut off"));
  for (const int number : {3, 3, 2}) deliver(foreign(number, ImageCoding::jpeg, false));
  EXPECT_EQ(publisher.on<images_t>("CAMERA").size(), 1U);
  EXPECT_EQ(reported(node->report(), "refused"), 3);
  images_t anew = foreign(0, ImageCoding::jpeg, false);  // time has begun anew
  for (image_t& image : anew.images) image.utime -= 3'000'000;
  anew.utime -= 3'000'000;
  deliver(anew);
  EXPECT_EQ(publisher.on<images_t>("CAMERA").size(), 2U);
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
  EXPECT_EQ(reported(node->report(), "refused"), 4);
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
  EXPECT_EQ(reported(report, "relayed") + reported(report, "refused") + errors, delivered);
  EXPECT_GT(reported(report, "refused"), 10);
  EXPECT_GT(errors, 10);
}

TEST_F(ForeignDriver, ItsSilenceIsTold) {
  start_relay();
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  while (node->report().detail.empty() && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_THAT(node->report().detail, HasSubstr("OPENNI_FRAME: no image for 0."));
}

}  // namespace
}  // namespace lcmslam
