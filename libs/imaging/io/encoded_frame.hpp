#pragma once
// One shot of the camera head as it travels.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// How an image's bytes are coded on the wire.
enum class ImageCoding {
  none,        ///< no image
  jpeg,        ///< colour
  raw_bgr,     ///< colour, 8-bit, rows back to back
  raw_rgb,     ///< the same, red first
  raw_gray,    ///< 8-bit
  depth_zlib,  ///< 16-bit little-endian millimetres along the optical axis, 0 = invalid, zlib
  depth_raw,   ///< the same without zlib
  gray_zlib    ///< 8-bit amplitude, zlib
};

struct EncodedImage {
  Utime utime = 0;  ///< when this image was taken, on its own camera's clock
  int width = 0;
  int height = 0;
  ImageCoding coding = ImageCoding::none;
  std::vector<std::uint8_t> bytes;
};

struct EncodedFrame {
  Utime utime = 0;  ///< of the colour image
  std::int64_t seq = 0;
  std::string sensor;
  EncodedImage colour;
  EncodedImage depth;
  EncodedImage amplitude;  ///< of the depth camera, may be absent
};

/// An image's bytes that do not decode: names what is wrong.
class CodecError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace lcmslam
