#pragma once
// The codecs of the wire: JPEG for colour, zlib for depth and amplitude.

#include <lcmslam/imaging/camera_model.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>

namespace lcmslam {

/// CV_8UC3 BGR. The encoders throw std::invalid_argument for an image of another type.
EncodedImage encode_colour(const cv::Mat& bgr, Utime utime, int jpeg_quality = 90);
/// Level 1: measured best for the price (640x480: 5 to 9 ms, 88 to 209 kB).
EncodedImage encode_depth(const cv::Mat& millimetres, Utime utime, int zlib_level = 1);
EncodedImage encode_amplitude(const cv::Mat& gray, Utime utime, int zlib_level = 1);

/// Each throws CodecError when the bytes are not what the header says; no bytes, however wrong, crash it.
cv::Mat decode_colour(const EncodedImage& image);  ///< CV_8UC3 BGR
cv::Mat decode_gray(const EncodedImage& image);    ///< CV_8UC1 of a colour or amplitude image; of a
                                                   ///< JPEG the luminance alone, at half the price
cv::Mat decode_depth(const EncodedImage& image);   ///< CV_16UC1 mm

/// Images that the frame does not have stay empty; one with neither colour nor depth is a CodecError.
RgbdFrame decode(const EncodedFrame& frame);
EncodedFrame encode(const RgbdFrame& frame, int jpeg_quality = 90);

}  // namespace lcmslam
