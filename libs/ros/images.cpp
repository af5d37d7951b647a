#include <lcmslam/ros/images.hpp>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <lcmslam/imaging/camera_model.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/imaging/io/jpeg.hpp>

namespace lcmslam::ros {
namespace {

bool contains(const std::string& text, const std::string& word) {
  return text.find(word) != std::string::npos;
}
bool is_compressed_depth(const Image& image) {
  return image.compressed && contains(image.encoding, "compressedDepth");
}
bool is_jpeg(ByteView bytes) {
  return bytes.size > 2 && bytes.data[0] == 0xff && bytes.data[1] == 0xd8;
}

/// compressedDepth puts 12 bytes before the PNG: a number that says nothing to us, and two that say how depth
/// in metres became an inverse.
constexpr std::size_t depth_head = 12;

ByteView png_of(const Image& image) {
  if (!is_compressed_depth(image)) return image.data;
  if (image.data.size < depth_head) throw CodecError("compressedDepth of less than its 12 bytes in front");
  return {image.data.data + depth_head, image.data.size - depth_head};
}

std::uint32_t big_endian(const std::uint8_t* b) {
  return std::uint32_t{b[0]} << 24 | std::uint32_t{b[1]} << 16 | std::uint32_t{b[2]} << 8 |
         std::uint32_t{b[3]};
}

/// Before anything is decoded, so that a damaged header cannot ask for gigabytes.
PixelCount png_size(ByteView png) {
  static constexpr std::uint8_t begin[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (png.size < 24 || !std::equal(begin, begin + 8, png.data) || std::memcmp(png.data + 12, "IHDR", 4) != 0)
    throw CodecError("is neither a JPEG nor a PNG image");
  const std::uint32_t most = 1U << 30;
  return {static_cast<int>(std::min(big_endian(png.data + 16), most)),
          static_cast<int>(std::min(big_endian(png.data + 20), most))};
}

PixelCount checked(PixelCount size) {
  if (size.width < 1 || size.height < 1 || size.width > max_image_side || size.height > max_image_side ||
      std::int64_t{size.width} * size.height > max_image_pixels)
    throw CodecError("is " + std::to_string(size.width) + "x" + std::to_string(size.height) +
                     ": must be 1 to 8192 a side and at most 32 Mpixel");
  return size;
}

cv::Mat decode_png(ByteView png, int flags) {
  const PixelCount size = checked(png_size(png));
  cv::Mat image;
  try {
    image = cv::imdecode(cv::Mat(1, static_cast<int>(png.size), CV_8U, const_cast<std::uint8_t*>(png.data)),
                         flags);    // which it does not change
  } catch (const cv::Exception&) {  // an empty image says the same
  }
  if (image.cols != size.width || image.rows != size.height) throw CodecError("is a damaged PNG");
  return image;
}

/// The pixels of an image that is not compressed, where they lie.
cv::Mat pixels(const Image& image, int type) {
  const PixelCount size = size_of(image);
  const std::size_t row = static_cast<std::size_t>(size.width) * CV_ELEM_SIZE(type);
  if (image.step < row || image.data.size / image.step < image.height)
    throw CodecError("is " + std::to_string(size.width) + "x" + std::to_string(size.height) + " " +
                     image.encoding + " in rows of " + std::to_string(image.step) + " bytes, but has " +
                     std::to_string(image.data.size) + " bytes");
  return {size.height, size.width, type, const_cast<std::uint8_t*>(image.data.data), image.step};
}

struct ColourEncoding {
  const char* name;
  int type;
  int to_bgr;  // -1: is so already
};
constexpr ColourEncoding colour_encodings[] = {
    {"bgr8", CV_8UC3, -1},
    {"8UC3", CV_8UC3, -1},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2BGR},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR},
    {"mono8", CV_8UC1, cv::COLOR_GRAY2BGR},
    {"8UC1", CV_8UC1, cv::COLOR_GRAY2BGR},
};

const ColourEncoding* find_colour(const std::string& name) {
  const auto* end = std::end(colour_encodings);
  const auto* found =
      std::find_if(std::begin(colour_encodings), end, [&](const auto& known) { return name == known.name; });
  return found == end ? nullptr : found;
}

std::uint16_t millimetres(double mm) {
  return mm > 0 && mm < 65534.5 ? static_cast<std::uint16_t>(mm + 0.5) : std::uint16_t{0};
}

template <class T>
T read_pixel(const std::uint8_t* bytes, bool big_endian) {
  std::array<std::uint8_t, sizeof(T)> copy;
  std::memcpy(copy.data(), bytes, sizeof(T));
  if (big_endian) std::reverse(copy.begin(), copy.end());
  T value;
  std::memcpy(&value, copy.data(), sizeof(T));
  return value;
}

/// Each pixel of type T by `convert` to mm.
template <class T, class Convert>
cv::Mat depth_by(const cv::Mat& pixels, bool big_endian, const Convert& convert) {
  cv::Mat depth(pixels.rows, pixels.cols, CV_16UC1);
  for (int v = 0; v < pixels.rows; ++v) {
    const auto* from = pixels.ptr<std::uint8_t>(v);
    auto* to = depth.ptr<std::uint16_t>(v);
    for (int u = 0; u < pixels.cols; ++u)
      to[u] = millimetres(convert(read_pixel<T>(from + static_cast<std::size_t>(u) * sizeof(T), big_endian)));
  }
  return depth;
}

cv::Mat depth_of_png(const Image& image) {
  const cv::Mat png = decode_png(png_of(image), cv::IMREAD_UNCHANGED);
  if (png.type() != CV_16UC1) throw CodecError("is a PNG, but none of 16 gray bits");
  const bool is_inverse = is_compressed_depth(image) && contains(image.encoding, "32FC1");
  if (!is_inverse)
    return depth_by<std::uint16_t>(png, false, [](std::uint16_t mm) { return double{1} * mm; });
  const double a = read_pixel<float>(image.data.data + 4, false),
               b = read_pixel<float>(image.data.data + 8, false);
  return depth_by<std::uint16_t>(
      png, false, [&](std::uint16_t value) { return value == 0 ? 0 : 1000 * a / (value - b); });
}

}  // namespace

ImageKind kind_of(const Image& image) {
  const std::string& encoding = image.encoding;
  if (contains(encoding, "16UC1") || contains(encoding, "32FC1") || contains(encoding, "mono16") ||
      contains(encoding, "compressedDepth"))
    return ImageKind::depth;
  if (image.compressed) return ImageKind::colour;
  return find_colour(encoding) == nullptr ? ImageKind::unknown : ImageKind::colour;
}

PixelCount size_of(const Image& image) {
  if (!image.compressed) {
    const auto side = [](std::uint32_t pixels) { return static_cast<int>(std::min(pixels, 1U << 30)); };
    return checked({side(image.width), side(image.height)});
  }
  if (is_jpeg(image.data)) {
    const ImageSize size = jpeg_size({image.data.data, image.data.data + image.data.size});
    return checked({size.width, size.height});
  }
  return checked(png_size(png_of(image)));
}

EncodedImage to_colour(const Image& image, Utime utime, int jpeg_quality) {
  if (image.compressed && is_jpeg(image.data)) {
    EncodedImage jpeg{utime, 0, 0, ImageCoding::jpeg, {image.data.data, image.data.data + image.data.size}};
    const PixelCount size = size_of(image);
    decode_jpeg(jpeg.bytes, {size.width, size.height}, true);  // to see that it is whole
    jpeg.width = size.width;
    jpeg.height = size.height;
    return jpeg;
  }
  if (image.compressed) return encode_colour(decode_png(image.data, cv::IMREAD_COLOR), utime, jpeg_quality);
  const ColourEncoding* encoding = find_colour(image.encoding);
  if (encoding == nullptr)
    throw CodecError("its encoding '" + image.encoding +
                     "' is no colour that is read: must be rgb8, bgr8, rgba8, bgra8 or mono8");
  const cv::Mat recorded = pixels(image, encoding->type);
  if (encoding->to_bgr < 0) return encode_colour(recorded, utime, jpeg_quality);
  cv::Mat bgr;  // not in place: the recording's bytes may be read only
  cv::cvtColor(recorded, bgr, encoding->to_bgr);
  return encode_colour(bgr, utime, jpeg_quality);
}

EncodedImage to_depth(const Image& image, Utime utime) {
  if (image.compressed) return encode_depth(depth_of_png(image), utime);
  if (image.encoding == "32FC1")
    return encode_depth(depth_by<float>(pixels(image, CV_32FC1), image.big_endian,
                                        [](float metres) { return 1000.0 * double{metres}; }),
                        utime);
  if (image.encoding != "16UC1" && image.encoding != "mono16")
    throw CodecError("its encoding '" + image.encoding +
                     "' is no depth that is read: must be 16UC1 (mm) or 32FC1 (m)");
  return encode_depth(depth_by<std::uint16_t>(pixels(image, CV_16UC1), image.big_endian,
                                              [](std::uint16_t mm) { return double{1} * mm; }),
                      utime);
}

}  // namespace lcmslam::ros
