#pragma once
// JPEG by libjpeg-turbo, with every size checked before memory is taken.

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/imaging/io/encoded_frame.hpp>

namespace lcmslam {

struct ImageSize {
  int width = 0;
  int height = 0;
};

/// Size that a JPEG's header declares; throws CodecError.
ImageSize jpeg_size(const std::vector<std::uint8_t>& bytes);

/// Bytes from a JPEG's begin to its end marker, which a driver's buffer may be longer than; throws CodecError
/// where there is none: the image is cut off, or no JPEG. What is between is not decoded.
std::size_t jpeg_bytes(const std::uint8_t* data, std::size_t size);

/// Decodes to CV_8UC3 BGR, or to CV_8UC1 from the luminance alone (half the price). Throws CodecError
/// when the data are damaged or the image is not of the declared size.
cv::Mat decode_jpeg(const std::vector<std::uint8_t>& bytes, ImageSize declared, bool gray);

/// CV_8UC3 BGR or CV_8UC1; quality 1 to 100, chroma 4:2:0.
std::vector<std::uint8_t> encode_jpeg(const cv::Mat& image, int quality);

}  // namespace lcmslam
