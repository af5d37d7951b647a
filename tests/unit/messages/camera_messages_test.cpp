#include <lcmslam/messages/camera_messages.hpp>

#include <gmock/gmock.h>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/origin.hpp>
#include "tests/unit/messages/error_of.hpp"
#include "tests/unit/messages/samples.hpp"
#include "tests/unit/messages/wire_sample.hpp"

namespace lcmslam {
namespace {

using testing::Bytes;
using testing::error_of;
using ::testing::HasSubstr;

template <class M>
M through_the_wire(const M& message) {
  const Bytes bytes = encode_message(message);
  return decode_message<M>(bytes.data(), bytes.size());
}

void expect_equal(const EncodedImage& a, const EncodedImage& b) {
  EXPECT_EQ(a.utime, b.utime);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.coding, b.coding);
  EXPECT_EQ(a.bytes, b.bytes);
}

TEST(CameraMessages, FrameComesBackAsItWas) {
  Random random(1);
  const EncodedFrame frame = testing::some_frame(random);
  const EncodedFrame back = from_message(through_the_wire(to_message(frame)));
  EXPECT_EQ(back.utime, frame.utime);
  EXPECT_EQ(back.sensor, "head");
  expect_equal(back.colour, frame.colour);
  expect_equal(back.depth, frame.depth);
  expect_equal(back.amplitude, frame.amplitude);
}

TEST(CameraMessages, EveryCodingComesBack) {
  Random random(2);
  for (const ImageCoding coding : {ImageCoding::raw_bgr, ImageCoding::raw_rgb, ImageCoding::raw_gray}) {
    EncodedFrame frame = testing::some_frame(random);
    const std::size_t pixels = 16 * 12;
    frame.colour.coding = coding;
    frame.colour.bytes.resize(coding == ImageCoding::raw_gray ? pixels : 3 * pixels);
    frame.depth.coding = ImageCoding::depth_raw;
    frame.depth.bytes.resize(2 * 8 * 6);
    frame.amplitude = {};
    const EncodedFrame back = from_message(through_the_wire(to_message(frame)));
    expect_equal(back.colour, frame.colour);
    expect_equal(back.depth, frame.depth);
    EXPECT_EQ(back.amplitude.coding, ImageCoding::none);
  }
}

/// images_t as a bot_core driver sends it: written by hand from bot_core's public definition.
Bytes foreign_images(std::int32_t depth_pixelformat, std::int64_t image_utime) {
  const auto put_image = [&](Bytes& b, std::int32_t width, std::int32_t height, std::int32_t stride,
                             std::int32_t format, const Bytes& data) {
    testing::put_integer(b, static_cast<std::uint64_t>(image_utime), 8);
    for (const std::int32_t value : {width, height, stride, format, static_cast<std::int32_t>(data.size())})
      testing::put_integer(b, static_cast<std::uint64_t>(value), 4);
    b.insert(b.end(), data.begin(), data.end());
    testing::put_integer(b, 1, 4);  // one metadata entry, of a key that we do not know
    testing::put_text(b, "exposure");
    testing::put_integer(b, 2, 4);
    testing::put_integer(b, 0x1234, 2);
  };
  Bytes b;
  testing::put_integer(b, 0x20ba4f05e8f5e33a, 8);
  testing::put_integer(b, 1'000'123, 8);
  testing::put_integer(b, 3, 4);
  for (const std::uint64_t type : {0, 1, 4}) testing::put_integer(b, type, 2);  // LEFT, RIGHT, DEPTH_MM
  put_image(b, 2, 1, 6, 859981650, {1, 2, 3, 4, 5, 6});                         // RGB
  put_image(b, 1, 1, 1, 1497715271, {9});
  put_image(b, 2, 1, 4, depth_pixelformat, {0xe8, 0x03, 0xd0, 0x07});  // 1000, 2000 mm
  return b;
}

TEST(CameraMessages, ForeignBotCoreImagesAreUnderstood) {
  const Bytes bytes = foreign_images(909199180, 1'000'100);
  const EncodedFrame frame = from_message(decode_message<images_t>(bytes.data(), bytes.size()));
  EXPECT_EQ(frame.utime, 1'000'123);
  EXPECT_EQ(frame.seq, -1);
  EXPECT_EQ(frame.sensor, "");
  EXPECT_EQ(frame.depth.utime, 1'000'100);
  const RgbdFrame decoded = decode(frame);
  EXPECT_EQ(decoded.colour.at<cv::Vec3b>(0, 0), cv::Vec3b(3, 2, 1));
  EXPECT_EQ(decoded.colour.at<cv::Vec3b>(0, 1), cv::Vec3b(6, 5, 4));
  EXPECT_EQ(decoded.depth.at<std::uint16_t>(0, 0), 1000);
  EXPECT_EQ(decoded.depth.at<std::uint16_t>(0, 1), 2000);
}

TEST(CameraMessages, ForeignImagesWithoutOwnStampsTakeTheMessages) {
  const Bytes bytes = foreign_images(909199180, 0);
  const EncodedFrame frame = from_message(decode_message<images_t>(bytes.data(), bytes.size()));
  EXPECT_EQ(frame.colour.utime, 1'000'123);
  EXPECT_EQ(frame.depth.utime, 1'000'123);
}

TEST(CameraMessages, AForeignMessageWithoutAStampTakesItsColourImages) {
  const Bytes bytes = foreign_images(909199180, 1'000'100);
  auto message = decode_message<images_t>(bytes.data(), bytes.size());
  message.utime = 0;
  EXPECT_EQ(from_message(message).utime, 1'000'100);
}

TEST(CameraMessages, BigEndianDepthIsRefusedRatherThanMisread) {
  const Bytes bytes = foreign_images(357, 1'000'100);
  const auto message = decode_message<images_t>(bytes.data(), bytes.size());
  EXPECT_THAT(error_of([&] { from_message(message); }), HasSubstr("big-endian"));
}

TEST(CameraMessages, ImpossibleImagesAreRefusedByName) {
  Random random(3);
  const images_t good = to_message(testing::some_frame(random));
  const auto error_with = [&](auto change) {
    images_t message = good;
    change(message);
    return error_of([&] { from_message(message); });
  };
  EXPECT_EQ(error_with([](images_t&) {}), "");
  EXPECT_THAT(error_with([](images_t& m) { m.images[0].width = 0; }), HasSubstr("image width"));
  EXPECT_THAT(error_with([](images_t& m) { m.images[1].width = -5; }), HasSubstr("image width"));
  EXPECT_THAT(error_with([](images_t& m) { m.images[1].height = 2'000'000'000; }), HasSubstr("image height"));
  EXPECT_THAT(error_with([](images_t& m) { m.images[0].pixelformat = 42; }), HasSubstr("pixelformat 42"));
  EXPECT_THAT(error_with([](images_t& m) { m.images[0].pixelformat = image_t::PIXEL_FORMAT_BGR; }),
              HasSubstr("are needed"));
  for (const int more : {-1, 1})
    EXPECT_THAT(
        error_with([&](images_t& m) {
          m.images[0].pixelformat = image_t::PIXEL_FORMAT_GRAY;
          m.images[0].data.resize(static_cast<std::size_t>(m.images[0].width * m.images[0].height + more));
        }),
        HasSubstr("are needed"));
  EXPECT_THAT(error_with([](images_t& m) { m.image_types[0] = images_t::RIGHT; }),
              HasSubstr("no colour image"));
  EXPECT_THAT(error_with([](images_t& m) { m.image_types[1] = images_t::DISPARITY; }),
              HasSubstr("no depth image"));
}

TEST(CameraMessages, ImagesOfAnotherSizeThanTheCalibrationsAreRefusedBeforeTheyAreDecoded) {
  Random random(4);
  const RgbdCalibration calibration = testing::some_calibration(random);
  const EncodedFrame good = testing::some_frame(random);
  decode_images(to_message(good), calibration);
  for (EncodedImage EncodedFrame::*image :
       {&EncodedFrame::colour, &EncodedFrame::depth, &EncodedFrame::amplitude}) {
    EncodedFrame frame = good;
    (frame.*image).width = 8192;
    (frame.*image).bytes = {1, 2, 3};  // what decodes them would say something else
    EXPECT_THAT(error_of([&] { decode_images(to_message(frame), calibration); }),
                HasSubstr("by its calibration it must be"));
  }
}

TEST(CameraMessages, MutatedFramesAreRefusedOrDecodeButNeverCrash) {
  Random random(4);
  const Bytes good = encode_message(to_message(testing::some_frame(random)));
  int refused = 0, whole = 0;
  for (int i = 0; i < 5000; ++i) {
    Bytes bytes = good;
    testing::mutate(bytes, random);
    try {
      const RgbdFrame frame = decode(from_message(decode_message<images_t>(bytes.data(), bytes.size())));
      EXPECT_EQ(frame.colour.type(), CV_8UC3);
      ++whole;
    } catch (const DecodeError&) {
      ++refused;
    } catch (const CodecError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 500);
  EXPECT_GT(whole, 100);  // flips inside a JPEG or in the metadata
}

// It has no field of its own; logs from before it tell the name alone.
TEST(CameraMessages, TheRollingShutterRidesWithTheSensorsName) {
  Random random(6);
  RgbdCalibration c = testing::some_calibration(random);
  for (const double seconds : {0.03, 1.0 / 30, 0.1}) {
    c.rolling_shutter = seconds;
    const camera_calibration_t message = through_the_wire(to_message(c));
    EXPECT_TRUE(tells_rolling_shutter(message));
    const RgbdCalibration back = from_message(message);
    EXPECT_EQ(back.rolling_shutter, seconds);
    EXPECT_EQ(back.sensor, c.sensor);
  }
  c.rolling_shutter = 0;
  camera_calibration_t message = to_message(c);
  EXPECT_EQ(message.sensor, c.sensor);
  EXPECT_FALSE(tells_rolling_shutter(message));
  EXPECT_EQ(from_message(message).rolling_shutter, 0);
  for (const char* wrong : {"", "fast", "0.03s", "-1", "0.2", "nan"}) {
    message.sensor = c.sensor + ";rolling_shutter=" + wrong;
    EXPECT_THROW(from_message(message), DecodeError) << wrong;
  }
}

TEST(CameraMessages, AnErrorRepeatsLittleOfALongSensorName) {
  Random random(6);
  camera_calibration_t message = to_message(testing::some_calibration(random));
  message.sensor = "\x1b[31m" + std::string(5'000'000, 'A') + ";rolling_shutter=x";
  try {
    from_message(message);
    FAIL();
  } catch (const DecodeError& error) {
    const std::string text = error.what();
    EXPECT_LT(text.size(), 200U);
    EXPECT_EQ(text.find('\x1b'), std::string::npos);
    EXPECT_NE(text.find("rolling_shutter must be"), std::string::npos) << text;
  }
}

// Likewise; and whoever decodes an image gets it without the error.
TEST(CameraMessages, DepthsErrorRidesWithTheSensorsNameAndIsTakenOut) {
  Random random(7);
  RgbdCalibration c = testing::some_calibration(random);
  c.depth_error = {0.02, 0, 0.006, 1.9, -0.3};
  for (const double seconds : {0.0, 0.03}) {
    c.rolling_shutter = seconds;
    const RgbdCalibration back = from_message(through_the_wire(to_message(c)));
    EXPECT_TRUE(back.depth_error == c.depth_error);
    EXPECT_EQ(back.rolling_shutter, seconds);
    EXPECT_EQ(back.sensor, c.sensor);
  }
  RgbdCalibration tilted = c;
  for (const DepthError& range : {DepthError{}, c.depth_error}) {
    tilted.depth_error = range;
    tilted.depth_error.tilt_x = 0.01, tilted.depth_error.tilt_y = -0.002;
    const RgbdCalibration back = from_message(through_the_wire(to_message(tilted)));
    EXPECT_TRUE(back.depth_error == tilted.depth_error);
    EXPECT_EQ(back.rolling_shutter, 0.03);
    EXPECT_EQ(back.sensor, c.sensor);
  }
  camera_calibration_t message = to_message(c);
  for (const char* wrong : {"", "0.02", "0.02,0,0.006,1.9", "0.02,0,0.006,1.9,x", "0.02,0,0.9,1,0"}) {
    message.sensor = c.sensor + ";depth_error=" + wrong;
    EXPECT_THROW(from_message(message), DecodeError) << wrong;
  }

  RgbdFrame frame;
  frame.utime = frame.depth_utime = 1;
  frame.colour = cv::Mat(c.colour.height, c.colour.width, CV_8UC3, cv::Scalar(10, 20, 30));
  frame.depth = cv::Mat(c.depth.height, c.depth.width, CV_16UC1, cv::Scalar(1500));
  frame.depth.at<std::uint16_t>(0, 0) = 1400;  // a constant image would be none
  RgbdCalibration plain = c;
  plain.depth_error = {};
  const EncodedFrame encoded = encode(frame);
  const cv::Mat raw = decode_images(encoded, plain).depth, corrected = decode_images(encoded, c).depth;
  const int v = c.depth.height / 2, u = c.depth.width / 2;
  EXPECT_EQ(raw.at<std::uint16_t>(v, u), 1500);
  const double stretch = c.depth.ray({u, v}).norm();
  EXPECT_NEAR(corrected.at<std::uint16_t>(v, u), 1000 * c.depth_error.corrected(1.5 * stretch) / stretch,
              0.6);
  // Another camera's tables are not used for it.
  EXPECT_EQ(decode_images(encoded, plain).depth.at<std::uint16_t>(v, u), 1500);
}

TEST(CameraMessages, CalibrationComesBackAsItWas) {
  Random random(5);
  const RgbdCalibration c = testing::some_calibration(random);
  const RgbdCalibration back = from_message(through_the_wire(to_message(c)));
  EXPECT_EQ(back.sensor, c.sensor);
  EXPECT_EQ(back.colour.width, c.colour.width);
  EXPECT_EQ(back.colour.height, c.colour.height);
  EXPECT_EQ(back.colour.fx, c.colour.fx);
  EXPECT_EQ(back.colour.fy, c.colour.fy);
  EXPECT_EQ(back.colour.cx, c.colour.cx);
  EXPECT_EQ(back.colour.cy, c.colour.cy);
  EXPECT_EQ(back.colour.distortion, c.colour.distortion);
  EXPECT_EQ(back.depth.width, c.depth.width);
  EXPECT_TRUE(back.depth.distortion.empty());
  EXPECT_EQ(back.depth_registered, c.depth_registered);
  EXPECT_TRUE(back.T_colour_depth.isApprox(c.T_colour_depth, 1e-12));
  EXPECT_EQ(back.has_mount, c.has_mount);
  EXPECT_TRUE(back.T_robot_camera.isApprox(c.T_robot_camera, 1e-12));
  EXPECT_EQ(back.depth_clock_offset, c.depth_clock_offset);
  EXPECT_EQ(back.depth_noise.constant, c.depth_noise.constant);
  EXPECT_EQ(back.depth_noise.quadratic, c.depth_noise.quadratic);
  EXPECT_EQ(back.depth_noise.offset, c.depth_noise.offset);
  EXPECT_EQ(back.depth_noise.amplitude, c.depth_noise.amplitude);
  EXPECT_EQ(back.depth_min, c.depth_min);
  EXPECT_EQ(back.depth_max, c.depth_max);
  EXPECT_EQ(back.pixel_sigma, c.pixel_sigma);
}

TEST(CameraMessages, ImpossibleCalibrationsAreRefusedByName) {
  Random random(6);
  const camera_calibration_t good = to_message(testing::some_calibration(random));
  const auto error_with = [&](auto change) {
    camera_calibration_t message = good;
    change(message);
    return error_of([&] { from_message(message); });
  };
  const double nan = std::nan(""), infinity = INFINITY;
  EXPECT_EQ(error_with([](auto&) {}), "");
  EXPECT_THAT(error_with([&](auto& m) { m.colour.fx = nan; }), HasSubstr("fx"));
  EXPECT_THAT(error_with([&](auto& m) { m.depth.fy = -1; }), HasSubstr("fy"));
  EXPECT_THAT(error_with([&](auto& m) { m.colour.width = 0; }), HasSubstr("width"));
  EXPECT_THAT(error_with([&](auto& m) { m.colour.distortion[1] = nan; }), HasSubstr("distortion"));
  EXPECT_THAT(error_with([&](auto& m) { m.T_colour_depth.quat[0] = 2; }), HasSubstr("T_colour_depth"));
  EXPECT_THAT(error_with([&](auto& m) { m.T_robot_camera.trans[2] = infinity; }),
              HasSubstr("T_robot_camera"));
  EXPECT_THAT(error_with([&](auto& m) { m.depth_clock_offset = 1e9; }), HasSubstr("depth_clock_offset"));
  EXPECT_THAT(error_with([&](auto& m) { m.depth_noise_constant = nan; }), HasSubstr("noise"));
  EXPECT_THAT(error_with([&](auto& m) { m.depth_min = 9; }), HasSubstr("depth"));
  EXPECT_THAT(error_with([&](auto& m) { m.depth_max = infinity; }), HasSubstr("depth_max"));
  EXPECT_THAT(error_with([&](auto& m) { m.pixel_sigma = 0; }), HasSubstr("pixel_sigma"));
}

TEST(Origin, OfCameraMessagesStandsInTheMetadata) {
  Random random(7);
  images_t message = to_message(testing::some_frame(random));
  EXPECT_EQ(origin(message).seq, -1);
  EXPECT_EQ(origin(message).sender, 0);
  for (const Origin o : {Origin{0, 1}, Origin{255, -1}, Origin{INT64_MAX, INT64_MIN}}) {
    set_origin(message, o);
    const images_t received = through_the_wire(message);
    EXPECT_EQ(origin(received).seq, o.seq);
    EXPECT_EQ(origin(received).sender, o.sender);
    EXPECT_EQ(received.images[0].nmetadata, 3);  // sensor, seq, sender: replaced and not repeated
    EXPECT_EQ(from_message(received).seq, o.seq);
  }
  const auto& metadata = message.images[0].metadata;
  EXPECT_EQ(metadata[1].key, "seq");
  EXPECT_EQ(metadata[1].value, (Bytes{0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f}));  // little-endian
}

TEST(Origin, OfAMessageWithoutImagesIsUnknown) {
  images_t message;
  message.n_images = 0;
  set_origin(message, {5, 6});
  EXPECT_EQ(origin(message).seq, -1);
  EXPECT_EQ(origin(message).sender, 0);
}

TEST(Origin, MetadataOfAnotherSizeIsNotANumber) {
  Random random(8);
  images_t message = to_message(testing::some_frame(random));
  set_text(message.images[0], "seq", "12");
  EXPECT_EQ(origin(message).seq, -1);
  EXPECT_EQ(get_text(message.images[0], "seq"), "12");
  EXPECT_EQ(get_text(message.images[0], "absent"), "");
}

}  // namespace
}  // namespace lcmslam
