#pragma once
// Image files, with their sizes checked before they are decoded.

#include <filesystem>
#include <opencv2/core.hpp>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>

namespace lcmslam {

/// A colour image ready for the wire: a JPEG as it is (decoded once to see that it is whole), other
/// formats encoded anew. Throws CodecError naming the file when it is missing, damaged or not of the
/// camera's size.
EncodedImage load_colour(const std::filesystem::path& file, Utime utime, const CameraModel& camera,
                         int jpeg_quality);

/// A 16-bit depth image, CV_16UC1 in mm; a pixel of value `depth_scale` is 1 m away. 0, 65535 and what
/// lies beyond 65.5 m become 0. Throws CodecError likewise.
cv::Mat load_depth(const std::filesystem::path& file, const CameraModel& camera, double depth_scale);

}  // namespace lcmslam
