#include <lcmslam/imaging/io/codec.hpp>

#include <libdeflate.h>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>

#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/imaging/io/jpeg.hpp>

namespace lcmslam {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "depth travels little-endian and is copied as it is");

std::string size_text(const EncodedImage& image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height);
}

void check_size(const EncodedImage& image) {
  if (image.width < 1 || image.height < 1 || image.width > max_image_side || image.height > max_image_side ||
      static_cast<std::int64_t>(image.width) * image.height > max_image_pixels)
    throw CodecError("image size " + size_text(image) + ": must be 1 to 8192 a side and at most 32 Mpixel");
}

// Raw pixels, rows back to back.
cv::Mat copy_raw(const EncodedImage& image, int type) {
  cv::Mat result(image.height, image.width, type);
  const std::size_t size = result.total() * result.elemSize();
  if (image.bytes.size() != size)
    throw CodecError("raw image " + size_text(image) + " has " + std::to_string(image.bytes.size()) +
                     " bytes, must be " + std::to_string(size));
  std::memcpy(result.data, image.bytes.data(), size);
  return result;
}

// libdeflate reads and writes zlib's format in less than half of zlib's time; its objects take a while to
// make, so each thread keeps its own.
struct Free {
  void operator()(libdeflate_decompressor* d) const { libdeflate_free_decompressor(d); }
  void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
};

libdeflate_decompressor& decompressor() {
  thread_local const std::unique_ptr<libdeflate_decompressor, Free> kept(libdeflate_alloc_decompressor());
  if (!kept) throw std::bad_alloc();
  return *kept;
}

libdeflate_compressor& compressor(int level) {
  thread_local std::unique_ptr<libdeflate_compressor, Free> kept;
  thread_local int kept_level = -1;
  if (!kept || level != kept_level) kept.reset(libdeflate_alloc_compressor(level));
  if (!kept) throw std::bad_alloc();
  kept_level = level;
  return *kept;
}

cv::Mat inflate_image(const EncodedImage& image, int type) {
  // zlib cannot shrink more than about 1032:1, so fewer bytes than that are refused before allocating.
  const std::size_t pixel = static_cast<std::size_t>(CV_ELEM_SIZE(type));
  const std::size_t size =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * pixel;
  if (image.bytes.size() < size / 1100)
    throw CodecError("zlib image " + size_text(image) + " has only " + std::to_string(image.bytes.size()) +
                     " bytes");
  cv::Mat result(image.height, image.width, type);
  std::size_t inflated = 0;
  const libdeflate_result status = libdeflate_zlib_decompress(
      &decompressor(), image.bytes.data(), image.bytes.size(), result.data, size, &inflated);
  if (status == LIBDEFLATE_INSUFFICIENT_SPACE)
    throw CodecError("zlib image " + size_text(image) + " holds more than its size");
  if (status != LIBDEFLATE_SUCCESS)
    throw CodecError("zlib image " + size_text(image) + " is truncated or damaged");
  if (inflated != size)
    throw CodecError("zlib image " + size_text(image) + " holds " + std::to_string(inflated) +
                     " bytes, must be " + std::to_string(size));
  return result;
}

EncodedImage deflate_image(const cv::Mat& pixels, int type, ImageCoding coding, Utime utime, int level) {
  if (pixels.empty() || pixels.type() != type)
    throw std::invalid_argument(type == CV_16UC1
                                    ? "encode_depth: the image must be CV_16UC1 and not empty"
                                    : "encode_amplitude: the image must be CV_8UC1 and not empty");
  if (level < 0 || level > 9) throw std::invalid_argument("zlib level must be 0 to 9");
  const cv::Mat packed = pixels.isContinuous() ? pixels : pixels.clone();
  EncodedImage image{utime, packed.cols, packed.rows, coding, {}};
  check_size(image);
  const std::size_t size = packed.total() * packed.elemSize();
  libdeflate_compressor& deflate = compressor(level);
  image.bytes.resize(libdeflate_zlib_compress_bound(&deflate, size));
  const std::size_t deflated =
      libdeflate_zlib_compress(&deflate, packed.data, size, image.bytes.data(), image.bytes.size());
  if (deflated == 0) throw std::runtime_error("libdeflate: compression failed");
  image.bytes.resize(deflated);
  return image;
}

// A cv::Mat whose pixels are B, G, R, from one of R, G, B.
void swap_red_blue(cv::Mat& image) {
  for (int v = 0; v < image.rows; ++v) {
    auto* row = image.ptr<cv::Vec3b>(v);
    for (int u = 0; u < image.cols; ++u) std::swap(row[u][0], row[u][2]);
  }
}

cv::Mat gray_to_bgr(const cv::Mat& gray) {
  cv::Mat bgr(gray.size(), CV_8UC3);
  for (int v = 0; v < gray.rows; ++v)
    for (int u = 0; u < gray.cols; ++u) bgr.at<cv::Vec3b>(v, u) = cv::Vec3b::all(gray.at<std::uint8_t>(v, u));
  return bgr;
}

// ITU-R BT.601 luma in 14-bit integers, as in JPEG.
cv::Mat bgr_to_gray(const cv::Mat& bgr) {
  cv::Mat gray(bgr.size(), CV_8UC1);
  for (int v = 0; v < bgr.rows; ++v) {
    const auto* row = bgr.ptr<cv::Vec3b>(v);
    for (int u = 0; u < bgr.cols; ++u)
      gray.at<std::uint8_t>(v, u) =
          static_cast<std::uint8_t>((1868 * row[u][0] + 9617 * row[u][1] + 4899 * row[u][2] + 8192) >> 14);
  }
  return gray;
}

[[noreturn]] void refuse_coding(const char* wanted) {
  throw CodecError(std::string("the image's coding is not one of a ") + wanted + " image");
}

}  // namespace

EncodedImage encode_colour(const cv::Mat& bgr, Utime utime, int jpeg_quality) {
  EncodedImage image{utime, bgr.cols, bgr.rows, ImageCoding::jpeg, encode_jpeg(bgr, jpeg_quality)};
  check_size(image);
  return image;
}

EncodedImage encode_depth(const cv::Mat& millimetres, Utime utime, int zlib_level) {
  return deflate_image(millimetres, CV_16UC1, ImageCoding::depth_zlib, utime, zlib_level);
}

EncodedImage encode_amplitude(const cv::Mat& gray, Utime utime, int zlib_level) {
  return deflate_image(gray, CV_8UC1, ImageCoding::gray_zlib, utime, zlib_level);
}

cv::Mat decode_colour(const EncodedImage& image) {
  check_size(image);
  switch (image.coding) {
    case ImageCoding::jpeg:
      return decode_jpeg(image.bytes, {image.width, image.height}, false);
    case ImageCoding::raw_bgr:
      return copy_raw(image, CV_8UC3);
    case ImageCoding::raw_rgb: {
      cv::Mat bgr = copy_raw(image, CV_8UC3);
      swap_red_blue(bgr);
      return bgr;
    }
    case ImageCoding::raw_gray:
      return gray_to_bgr(copy_raw(image, CV_8UC1));
    default:
      refuse_coding("colour");
  }
}

cv::Mat decode_gray(const EncodedImage& image) {
  check_size(image);
  switch (image.coding) {
    case ImageCoding::jpeg:
      return decode_jpeg(image.bytes, {image.width, image.height}, true);
    case ImageCoding::raw_gray:
      return copy_raw(image, CV_8UC1);
    case ImageCoding::gray_zlib:
      return inflate_image(image, CV_8UC1);
    case ImageCoding::raw_bgr:
    case ImageCoding::raw_rgb:
      return bgr_to_gray(decode_colour(image));
    default:
      refuse_coding("gray");
  }
}

cv::Mat decode_depth(const EncodedImage& image) {
  check_size(image);
  switch (image.coding) {
    case ImageCoding::depth_zlib:
      return inflate_image(image, CV_16UC1);
    case ImageCoding::depth_raw:
      return copy_raw(image, CV_16UC1);
    default:
      refuse_coding("depth");
  }
}

RgbdFrame decode(const EncodedFrame& frame) {
  if (frame.colour.coding == ImageCoding::none && frame.depth.coding == ImageCoding::none)
    throw CodecError("the frame has neither a colour nor a depth image");
  RgbdFrame result;
  result.utime = frame.utime;
  result.depth_utime = frame.depth.coding == ImageCoding::none ? frame.utime : frame.depth.utime;
  result.seq = frame.seq;
  result.sensor = frame.sensor;
  if (frame.colour.coding != ImageCoding::none) result.colour = decode_colour(frame.colour);
  if (frame.depth.coding != ImageCoding::none) result.depth = decode_depth(frame.depth);
  if (frame.amplitude.coding != ImageCoding::none) {
    result.amplitude = decode_gray(frame.amplitude);
    if (result.amplitude.size() != result.depth.size())
      throw CodecError("the amplitude image (" + size_text(frame.amplitude) +
                       ") must have the depth image's size (" + size_text(frame.depth) + ")");
  }
  return result;
}

EncodedFrame encode(const RgbdFrame& frame, int jpeg_quality) {
  EncodedFrame result;
  result.utime = frame.utime;
  result.seq = frame.seq;
  result.sensor = frame.sensor;
  if (!frame.colour.empty()) result.colour = encode_colour(frame.colour, frame.utime, jpeg_quality);
  if (!frame.depth.empty()) result.depth = encode_depth(frame.depth, frame.depth_utime);
  if (!frame.amplitude.empty()) result.amplitude = encode_amplitude(frame.amplitude, frame.depth_utime);
  return result;
}

}  // namespace lcmslam
