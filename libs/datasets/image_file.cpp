#include <lcmslam/datasets/image_file.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/imaging/io/jpeg.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

[[noreturn]] void fail(const fs::path& file, const std::string& problem) {
  throw CodecError(file.string() + ": " + problem);
}

Bytes read_bytes(const fs::path& file) {
  constexpr std::uintmax_t most = 200'000'000;
  std::error_code error;
  if (!fs::exists(file, error)) fail(file, "is missing");
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) fail(file, "cannot be read: " + error.message());
  if (size == 0) fail(file, "is empty");
  if (size > most) fail(file, "is larger than 200 MB, not an image");
  std::ifstream stream(file, std::ios::binary);
  Bytes bytes(size);
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    fail(file, "cannot be read");
  return bytes;
}

bool is_jpeg(const Bytes& bytes) {
  return bytes.size() > 2 && bytes[0] == 0xff && bytes[1] == 0xd8;
}

int big_endian(const std::uint8_t* b) {
  return static_cast<int>((std::uint32_t{b[0]} << 24 | std::uint32_t{b[1]} << 16 | std::uint32_t{b[2]} << 8 |
                           std::uint32_t{b[3]}) &
                          0x7fffffff);
}

// Size by the header, so that a damaged one cannot ask for gigabytes: JPEG, PNG (its first chunk is
// IHDR), PGM and PPM.
cv::Size header_size(const fs::path& file, const Bytes& bytes) {
  static constexpr std::uint8_t png[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (is_jpeg(bytes)) {
    const ImageSize size = jpeg_size(bytes);
    return {size.width, size.height};
  }
  if (bytes.size() >= 24 && std::equal(png, png + 8, bytes.begin()) &&
      std::memcmp(bytes.data() + 12, "IHDR", 4) == 0)
    return {big_endian(bytes.data() + 16), big_endian(bytes.data() + 20)};
  if (bytes.size() > 2 && bytes[0] == 'P' && std::strchr("2356", bytes[1]) != nullptr) {
    std::istringstream header(
        std::string(bytes.begin() + 2,
                    bytes.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(bytes.size(), 2000))));
    cv::Size size;
    std::string comment;
    while ((header >> std::ws).peek() == '#') std::getline(header, comment);
    header >> size.width;
    while ((header >> std::ws).peek() == '#') std::getline(header, comment);
    if (header >> size.height) return size;
  }
  fail(file, "is not a whole JPEG, PNG, PGM or PPM image");
}

void check_size(const fs::path& file, const cv::Size& size, const CameraModel& camera) {
  if (size.width == camera.width && size.height == camera.height) return;
  std::ostringstream problem;
  problem << "is " << size.width << "x" << size.height << ", by the calibration it must be " << camera.width
          << "x" << camera.height;
  fail(file, problem.str());
}

// Reads, checks the size, decodes.
cv::Mat decode_file(const fs::path& file, const Bytes& bytes, const CameraModel& camera, int flags) {
  check_size(file, header_size(file, bytes), camera);
  cv::Mat image;
  try {
    image = cv::imdecode(bytes, flags);
  } catch (const cv::Exception&) {  // an empty image says the same
  }
  if (image.empty()) fail(file, "is damaged");
  check_size(file, image.size(), camera);
  return image;
}

}  // namespace

EncodedImage load_colour(const fs::path& file, Utime utime, const CameraModel& camera, int jpeg_quality) {
  Bytes bytes = read_bytes(file);
  if (!is_jpeg(bytes))
    return encode_colour(decode_file(file, bytes, camera, cv::IMREAD_COLOR), utime, jpeg_quality);
  try {
    const ImageSize size = jpeg_size(bytes);
    check_size(file, {size.width, size.height}, camera);
    decode_jpeg(bytes, size, true);
  } catch (const CodecError& error) {
    if (std::strstr(error.what(), file.c_str()) != nullptr) throw;
    fail(file, error.what());
  }
  return {utime, camera.width, camera.height, ImageCoding::jpeg, std::move(bytes)};
}

cv::Mat load_depth(const fs::path& file, const CameraModel& camera, double depth_scale) {
  const Bytes bytes = read_bytes(file);
  if (is_jpeg(bytes)) fail(file, "is a JPEG, a depth image must have 16 bits (PNG or PGM)");
  cv::Mat depth = decode_file(file, bytes, camera, cv::IMREAD_UNCHANGED);
  if (depth.type() != CV_16UC1) fail(file, "is not a gray image of 16 bits");
  const double to_mm = 1000 / depth_scale;
  for (int v = 0; v < depth.rows; ++v) {
    auto* row = depth.ptr<std::uint16_t>(v);
    for (int u = 0; u < depth.cols; ++u) {
      const double mm = std::min(row[u] * to_mm + 0.5, 1e6);
      row[u] = row[u] == 65535 || mm >= 65535 ? std::uint16_t{0}
                                              : static_cast<std::uint16_t>(static_cast<int>(mm));
    }
  }
  return depth;
}

}  // namespace lcmslam
