#include <lcmslam/rendering/animation.hpp>

#include <cmath>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

#include <lcmslam/files/atomic_file.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t signature_size = 8, frame_of_chunk = 12;  // bytes; length, type and CRC of a chunk

std::string big_endian(std::uint32_t number, int bytes = 4) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(number >> (8 * i));
  return text;
}

std::uint32_t read_number(const std::string& bytes, std::size_t at) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < 4; ++i) number = number << 8 | static_cast<unsigned char>(bytes[at + i]);
  return number;
}

/// CRC-32 as PNG has it (polynomial 0xedb88320, reflected).
std::uint32_t crc(const std::string& bytes) {
  std::uint32_t remainder = 0xffffffff;
  for (const char c : bytes) {
    remainder ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) remainder = (remainder >> 1) ^ ((remainder & 1) != 0 ? 0xedb88320 : 0);
  }
  return ~remainder;
}

std::string chunk(const std::string& type, const std::string& data) {
  return big_endian(static_cast<std::uint32_t>(data.size())) + type + data + big_endian(crc(type + data));
}

struct Png {
  std::string signature, header;   // the first eight bytes, the data of IHDR
  std::vector<std::string> image;  // the data of each IDAT
};

Png encode(const cv::Mat& picture) {
  std::vector<uchar> encoded;
  if (!cv::imencode(".png", picture, encoded)) throw std::runtime_error("not a picture");
  const std::string bytes(encoded.begin(), encoded.end());
  Png png;
  png.signature = bytes.substr(0, signature_size);
  for (std::size_t at = signature_size; at + frame_of_chunk <= bytes.size();) {
    const std::size_t size = read_number(bytes, at);
    const std::string type = bytes.substr(at + 4, 4), data = bytes.substr(at + 8, size);
    if (type == "IHDR") png.header = data;
    if (type == "IDAT") png.image.push_back(data);
    at += frame_of_chunk + size;
  }
  return png;
}

/// fcTL: a frame as large as the picture, in the place of the one before.
std::string frame_control(std::uint32_t number, const cv::Mat& picture, double seconds) {
  const auto milliseconds = static_cast<std::uint32_t>(std::lround(1000 * seconds));
  return chunk("fcTL", big_endian(number) + big_endian(static_cast<std::uint32_t>(picture.cols)) +
                           big_endian(static_cast<std::uint32_t>(picture.rows)) + big_endian(0) +
                           big_endian(0) + big_endian(milliseconds, 2) + big_endian(1000, 2) +
                           std::string(2, '\0'));
}

}  // namespace

void save_animation(const FilePlace& file, const std::vector<cv::Mat>& pictures, double seconds_a_picture) {
  if (pictures.empty()) throw std::invalid_argument("animation: there are no pictures");
  if (!(seconds_a_picture >= 0.001 && seconds_a_picture <= 60))
    throw std::invalid_argument("animation: a picture must stay for 0.001 to 60 s");
  std::string bytes;
  std::uint32_t number = 0;  // of fcTL and fdAT chunks
  for (const cv::Mat& picture : pictures) {
    if (picture.size() != pictures[0].size() || picture.type() != CV_8UC3)
      throw std::invalid_argument("animation: all pictures must be CV_8UC3 and of one size");
    const Png png = encode(picture);
    const bool first = bytes.empty();
    if (first)
      bytes = png.signature + chunk("IHDR", png.header) +
              chunk("acTL", big_endian(static_cast<std::uint32_t>(pictures.size())) + big_endian(0));
    bytes += frame_control(number++, picture, seconds_a_picture);
    for (const std::string& data : png.image)
      bytes += first ? chunk("IDAT", data) : chunk("fdAT", big_endian(number++) + data);
  }
  write_atomically(file, bytes + chunk("IEND", ""));
}

}  // namespace lcmslam
