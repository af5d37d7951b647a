#include <lcmslam/rendering/png.hpp>

#include <libdeflate.h>
#include <memory>
#include <new>
#include <stdexcept>
#include <vector>

namespace lcmslam {
namespace {

constexpr int level = 2;  // the fastest for drawn pictures; higher ones make them hardly smaller
constexpr char up = 2;    // the filter: bytes less those above them

/// Rows of R, G, B, each behind the byte that names its filter.
std::string filtered_rows(const cv::Mat& picture) {
  const std::vector<cv::Vec3b> nothing(static_cast<std::size_t>(picture.cols));
  std::string bytes;
  bytes.resize(static_cast<std::size_t>(picture.rows) * (1 + 3 * static_cast<std::size_t>(picture.cols)));
  char* to = bytes.data();
  const cv::Vec3b* above = nothing.data();
  for (int row = 0; row < picture.rows; ++row) {
    const auto* here = picture.ptr<cv::Vec3b>(row);
    *to++ = up;
    for (int column = 0; column < picture.cols; ++column)
      for (const int channel : {2, 1, 0})
        *to++ = static_cast<char>(here[column][channel] - above[column][channel]);
    above = here;
  }
  return bytes;
}

}  // namespace

std::string big_endian(std::uint32_t number, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(number >> (8 * i));
  return text;
}

std::string png_chunk(const std::string& type, const std::string& data) {
  const std::uint32_t crc =
      libdeflate_crc32(libdeflate_crc32(0, type.data(), type.size()), data.data(), data.size());
  return big_endian(static_cast<std::uint32_t>(data.size())) + type + data + big_endian(crc);
}

std::string png_signature() {
  return "\x89PNG\r\n\x1a\n";
}

std::string png_header(const cv::Size& size) {
  const std::string rgb_of_8_bits("\x08\x02\0\0\0", 5);
  return big_endian(static_cast<std::uint32_t>(size.width)) +
         big_endian(static_cast<std::uint32_t>(size.height)) + rgb_of_8_bits;
}

std::string png_image(const cv::Mat& picture) {
  if (picture.empty() || picture.type() != CV_8UC3)
    throw std::invalid_argument("PNG: the picture must be CV_8UC3 and not empty");
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> deflate(
      libdeflate_alloc_compressor(level), libdeflate_free_compressor);
  if (!deflate) throw std::bad_alloc();
  const std::string rows = filtered_rows(picture);
  std::string packed(libdeflate_zlib_compress_bound(deflate.get(), rows.size()), '\0');
  packed.resize(
      libdeflate_zlib_compress(deflate.get(), rows.data(), rows.size(), packed.data(), packed.size()));
  return packed;
}

std::string encode_png(const cv::Mat& picture) {
  return png_signature() + png_chunk("IHDR", png_header(picture.size())) +
         png_chunk("IDAT", png_image(picture)) + png_chunk("IEND", "");
}

}  // namespace lcmslam
