#pragma once
// ROS's images as lcmslam's: colour as JPEG, depth as zlib millimetres.

#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/ros/messages.hpp>

namespace lcmslam::ros {

enum class ImageKind { colour, depth, unknown };

/// By its encoding or format.
ImageKind kind_of(const Image& image);

/// Pixels that the image has, of a compressed one by its header. Throws CodecError.
struct PixelCount {
  int width = 0, height = 0;
};
PixelCount size_of(const Image& image);

/// rgb8, bgr8, rgba8, bgra8, mono8, 8UC1, 8UC3, JPEG (passes through as it is) and PNG. Throws CodecError
/// naming what is wrong.
EncodedImage to_colour(const Image& image, Utime utime, int jpeg_quality);

/// 16UC1 and mono16 (mm), 32FC1 (m), PNG of 16 bits (mm), and compressedDepth of both. 65535, NaN, and what
/// lies beyond 65.5 m become 0. Throws CodecError likewise.
EncodedImage to_depth(const Image& image, Utime utime);

}  // namespace lcmslam::ros
