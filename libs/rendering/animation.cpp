#include <lcmslam/rendering/animation.hpp>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/rendering/png.hpp>

namespace lcmslam {
namespace {

/// fcTL: a frame as large as the picture, in the place of the one before.
std::string frame_control(std::uint32_t number, const cv::Mat& picture, double seconds) {
  const auto milliseconds = static_cast<std::uint32_t>(std::lround(1000 * seconds));
  return png_chunk("fcTL", big_endian(number) + big_endian(static_cast<std::uint32_t>(picture.cols)) +
                               big_endian(static_cast<std::uint32_t>(picture.rows)) + big_endian(0) +
                               big_endian(0) + big_endian(milliseconds, 2) + big_endian(1000, 2) +
                               std::string(2, '\0'));
}

}  // namespace

bool may_stay(double seconds) {
  return seconds >= 0.001 && seconds <= 60;
}

void save_animation(const FilePlace& file, const std::vector<cv::Mat>& pictures, double seconds_a_picture) {
  if (pictures.empty()) throw std::invalid_argument("animation: there are no pictures");
  if (!may_stay(seconds_a_picture))
    throw std::invalid_argument("animation: a picture must stay for 0.001 to 60 s");
  std::string bytes;
  std::uint32_t number = 0;  // of fcTL and fdAT chunks
  for (const cv::Mat& picture : pictures) {
    if (picture.size() != pictures[0].size() || picture.type() != CV_8UC3)
      throw std::invalid_argument("animation: all pictures must be CV_8UC3 and of one size");
    const std::string image = png_image(picture);
    const bool first = bytes.empty();
    if (first)
      bytes = png_signature() + png_chunk("IHDR", png_header(picture.size())) +
              png_chunk("acTL", big_endian(static_cast<std::uint32_t>(pictures.size())) + big_endian(0));
    bytes += frame_control(number++, picture, seconds_a_picture);
    bytes += first ? png_chunk("IDAT", image) : png_chunk("fdAT", big_endian(number++) + image);
  }
  write_atomically(file, bytes + png_chunk("IEND", ""));
}

}  // namespace lcmslam
