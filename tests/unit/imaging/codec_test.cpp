// Codecs of the wire: lossless where promised, and proof against any bytes.

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/imaging/io/jpeg.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>

namespace lcmslam {
namespace {

using testing::HasSubstr;

std::string error_of(const std::function<void()>& decoding) {
  try {
    decoding();
  } catch (const CodecError& error) {
    return error.what();
  }
  return "";
}

// A smooth picture, as cameras give it: JPEG loses little of it.
cv::Mat smooth_picture(int width, int height) {
  cv::Mat image(height, width, CV_8UC3);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      image.at<cv::Vec3b>(v, u) = {static_cast<std::uint8_t>(127 + 100 * std::sin(u * 0.05)),
                                   static_cast<std::uint8_t>(127 + 100 * std::cos(v * 0.04)),
                                   static_cast<std::uint8_t>(40 + (u + v) % 160 / 2)};
  return image;
}

cv::Mat random_image(int width, int height, int type, std::uint64_t seed) {
  Random random(seed);
  cv::Mat image(height, width, type);
  for (std::size_t i = 0; i < image.total() * image.elemSize(); ++i)
    image.data[i] = static_cast<std::uint8_t>(random.below(256));
  return image;
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

RgbdFrame small_frame() {
  RgbdFrame frame;
  frame.utime = 1000;
  frame.depth_utime = 1015;
  frame.seq = 7;
  frame.sensor = "head";
  frame.colour = smooth_picture(64, 48);
  frame.depth = random_image(33, 17, CV_16UC1, 5);
  frame.amplitude = random_image(33, 17, CV_8UC1, 6);
  return frame;
}

TEST(Codec, DepthAndAmplitudeAreLossless) {
  const cv::Mat depth = random_image(176, 144, CV_16UC1, 1);
  const cv::Mat amplitude = random_image(31, 7, CV_8UC1, 2);
  for (int level : {0, 1, 6}) {
    EXPECT_TRUE(equal(decode_depth(encode_depth(depth, 5, level)), depth));
    EXPECT_TRUE(equal(decode_gray(encode_amplitude(amplitude, 5, level)), amplitude));
  }
}

TEST(Codec, PartOfALargerImageIsPackedFirst) {
  const cv::Mat large = random_image(40, 30, CV_16UC1, 3);
  const cv::Mat part = large(cv::Rect(5, 6, 11, 12));
  EXPECT_TRUE(equal(decode_depth(encode_depth(part, 0)), part));
}

TEST(Codec, JpegKeepsAPictureAndItsOddSize) {
  const cv::Mat picture = smooth_picture(101, 57);
  const EncodedImage image = encode_colour(picture, 5, 95);
  EXPECT_EQ(image.utime, 5);
  EXPECT_EQ(image.width, 101);
  EXPECT_EQ(image.height, 57);
  EXPECT_LT(image.bytes.size(), picture.total() * 3 / 2);
  const cv::Mat decoded = decode_colour(image);
  ASSERT_EQ(decoded.size(), picture.size());
  EXPECT_LT(cv::norm(decoded, picture, cv::NORM_L1) / static_cast<double>(picture.total() * 3), 3.0);
}

TEST(Codec, GrayOfAJpegIsItsLuminance) {
  const cv::Mat picture = smooth_picture(96, 64);
  const EncodedImage jpeg = encode_colour(picture, 0, 95);
  const cv::Mat gray = decode_gray(jpeg);
  ASSERT_EQ(gray.type(), CV_8UC1);
  EncodedImage raw = jpeg;
  raw.coding = ImageCoding::raw_bgr;
  raw.bytes.assign(picture.datastart, picture.dataend);
  EXPECT_LT(cv::norm(gray, decode_gray(raw), cv::NORM_L1) / static_cast<double>(gray.total()), 1.5);
}

TEST(Codec, AJpegEndsAtItsMarkerWhateverFollows) {
  cv::Mat image(48, 64, CV_8UC3);
  cv::randu(image, 0, 255);
  const std::vector<std::uint8_t> jpeg = encode_jpeg(image, 90);
  std::vector<std::uint8_t> padded = jpeg;
  padded.insert(padded.end(), jpeg.begin(), jpeg.end());  // what was in the buffer before
  EXPECT_EQ(jpeg_bytes(jpeg.data(), jpeg.size()), jpeg.size());
  EXPECT_EQ(jpeg_bytes(padded.data(), padded.size()), jpeg.size());
  for (std::size_t size = 0; size < jpeg.size(); ++size)
    EXPECT_THROW(jpeg_bytes(jpeg.data(), size), CodecError) << size;
  EXPECT_THROW(jpeg_bytes(jpeg.data() + 1, jpeg.size() - 1), CodecError);
}

TEST(Codec, RawImages) {
  const EncodedImage raw{0, 2, 1, ImageCoding::raw_rgb, {1, 2, 3, 4, 5, 6}};
  EXPECT_EQ(decode_colour(raw).at<cv::Vec3b>(0, 1), cv::Vec3b(6, 5, 4));
  EncodedImage bgr = raw;
  bgr.coding = ImageCoding::raw_bgr;
  EXPECT_EQ(decode_colour(bgr).at<cv::Vec3b>(0, 1), cv::Vec3b(4, 5, 6));
  const EncodedImage gray{0, 3, 2, ImageCoding::raw_gray, {9, 8, 7, 6, 5, 4}};
  EXPECT_EQ(decode_gray(gray).at<std::uint8_t>(1, 0), 6);
  EXPECT_EQ(decode_colour(gray).at<cv::Vec3b>(1, 0), cv::Vec3b(6, 6, 6));
  const EncodedImage depth{0, 1, 2, ImageCoding::depth_raw, {0x34, 0x12, 0xff, 0x00}};
  EXPECT_EQ(decode_depth(depth).at<std::uint16_t>(0, 0), 0x1234);
  EXPECT_EQ(decode_depth(depth).at<std::uint16_t>(1, 0), 0x00ff);
}

TEST(Codec, WholeFrame) {
  const RgbdFrame frame = small_frame();
  const RgbdFrame decoded = decode(encode(frame));
  EXPECT_EQ(decoded.utime, 1000);
  EXPECT_EQ(decoded.depth_utime, 1015);
  EXPECT_EQ(decoded.seq, 7);
  EXPECT_EQ(decoded.sensor, "head");
  EXPECT_EQ(decoded.colour.size(), frame.colour.size());
  EXPECT_TRUE(equal(decoded.depth, frame.depth));
  EXPECT_TRUE(equal(decoded.amplitude, frame.amplitude));
}

TEST(Codec, FrameOfOneImage) {
  RgbdFrame frame = small_frame();
  frame.depth.release();
  frame.amplitude.release();
  const RgbdFrame decoded = decode(encode(frame));
  EXPECT_TRUE(decoded.depth.empty());
  EXPECT_EQ(decoded.depth_utime, decoded.utime);
  EXPECT_THAT(error_of([] { decode(EncodedFrame{}); }), HasSubstr("neither"));
}

TEST(Codec, ErrorsSayWhatIsWrong) {
  const EncodedFrame good = encode(small_frame());
  EncodedImage image = good.colour;
  image.width = 65;
  EXPECT_THAT(error_of([&] { decode_colour(image); }), HasSubstr("64x48 pixels, declared are 65x48"));
  image = good.depth;
  image.height = 18;
  EXPECT_THAT(error_of([&] { decode_depth(image); }), HasSubstr("must be"));
  image.height = 16;
  EXPECT_THAT(error_of([&] { decode_depth(image); }), HasSubstr("33x16"));
  EXPECT_THAT(error_of([&] { decode_depth(good.colour); }), HasSubstr("coding"));
  EXPECT_THAT(error_of([&] { decode_colour(good.depth); }), HasSubstr("coding"));
  EncodedFrame frame = good;
  frame.amplitude = encode_amplitude(random_image(33, 16, CV_8UC1, 1), 0);
  EXPECT_THAT(error_of([&] { decode(frame); }), HasSubstr("amplitude"));
  image = {0, 4, 4, ImageCoding::raw_bgr, std::vector<std::uint8_t>(47)};
  EXPECT_THAT(error_of([&] { decode_colour(image); }), HasSubstr("47 bytes, must be 48"));
}

TEST(Codec, AbsurdSizesAreRefusedBeforeAllocating) {
  for (const auto& [width, height] : {std::pair{0, 10}, std::pair{-1, -1}, std::pair{8193, 1},
                                      std::pair{8192, 8192}, std::pair{std::numeric_limits<int>::max(), 2}}) {
    for (auto coding : {ImageCoding::jpeg, ImageCoding::depth_zlib, ImageCoding::raw_bgr}) {
      const EncodedImage image{0, width, height, coding, {1, 2, 3}};
      EXPECT_THROW(coding == ImageCoding::depth_zlib ? decode_depth(image) : decode_colour(image),
                   CodecError);
    }
  }
  // Within the limits, but no few bytes can hold so much.
  EXPECT_THROW(decode_depth({0, 8192, 4096, ImageCoding::depth_zlib, {1, 2, 3}}), CodecError);
}

TEST(Codec, EncodersRefuseOtherTypes) {
  EXPECT_THROW(encode_depth(cv::Mat(2, 2, CV_8UC1), 0), std::invalid_argument);
  EXPECT_THROW(encode_amplitude(cv::Mat(2, 2, CV_16UC1), 0), std::invalid_argument);
  EXPECT_THROW(encode_colour(cv::Mat(2, 2, CV_32FC3), 0), std::invalid_argument);
  EXPECT_THROW(encode_colour(cv::Mat(), 0), std::invalid_argument);
  EXPECT_THROW(encode_colour(smooth_picture(4, 4), 0, 101), std::invalid_argument);
}

// Decodes every image of the frame; whatever comes out has the declared size.
bool decodes(const EncodedFrame& frame) {
  try {
    const RgbdFrame result = decode(frame);
    EXPECT_EQ(result.colour.size(), cv::Size(frame.colour.width, frame.colour.height));
    EXPECT_EQ(result.depth.size(), cv::Size(frame.depth.width, frame.depth.height));
    EXPECT_EQ(decode_gray(frame.colour).size(), result.colour.size());
    return true;
  } catch (const CodecError&) {
    return false;
  }
}

TEST(Codec, TruncatedBytesAreAnError) {
  const EncodedFrame good = encode(small_frame());
  ASSERT_TRUE(decodes(good));
  for (auto member : {&EncodedFrame::colour, &EncodedFrame::depth, &EncodedFrame::amplitude}) {
    const std::size_t size = (good.*member).bytes.size();
    for (std::size_t length = 0; length + 2 < size; length += 1 + length / 40) {
      EncodedFrame frame = good;
      (frame.*member).bytes.resize(length);
      EXPECT_FALSE(decodes(frame)) << length << " of " << size;
    }
  }
}

TEST(Codec, FlippedBitsNeverCrash) {
  const EncodedFrame good = encode(small_frame());
  Random random(11);
  int refused = 0;
  constexpr int trials = 3000;
  for (int i = 0; i < trials; ++i) {
    EncodedFrame frame = good;
    EncodedImage* images[] = {&frame.colour, &frame.depth, &frame.amplitude};
    auto& bytes = images[random.below(3)]->bytes;
    for (std::uint64_t flips = 1 + random.below(8); flips > 0; --flips)
      bytes[random.below(bytes.size())] ^= static_cast<std::uint8_t>(1u << random.below(8));
    refused += decodes(frame) ? 0 : 1;
  }
  // zlib's checksum finds every damage; JPEG has none, so some pictures are merely ugly.
  EXPECT_GT(refused, trials / 2);
}

TEST(Codec, RandomBytesNeverCrash) {
  Random random(12);
  for (int i = 0; i < 5000; ++i) {
    EncodedImage image;
    image.width = static_cast<int>(random.below(70));
    image.height = static_cast<int>(random.below(50));
    image.coding = static_cast<ImageCoding>(random.below(9));
    image.bytes.resize(random.below(400));
    for (auto& byte : image.bytes) byte = static_cast<std::uint8_t>(random.below(256));
    if (image.bytes.size() > 4 && random.below(2) == 0) {  // the start of a JPEG or of a zlib stream
      const bool jpeg = image.coding == ImageCoding::jpeg;
      image.bytes[0] = jpeg ? 0xff : 0x78;
      image.bytes[1] = jpeg ? 0xd8 : 0x01;
      image.bytes[2] = jpeg ? 0xff : image.bytes[2];
    }
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    for (auto decoder : {decode_colour, decode_gray, decode_depth}) {
      try {
        EXPECT_EQ(decoder(image).total(), pixels);
      } catch (const CodecError&) {
      }
    }
  }
}

}  // namespace
}  // namespace lcmslam
