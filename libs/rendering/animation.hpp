#pragma once
// Pictures that move: APNG, a PNG file with more frames behind the first one (W3C, PNG third edition, 11.3).
// Browsers play it; what knows only PNG shows the first frame.

#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/files/part_file.hpp>

namespace lcmslam {

/// Whether a picture may stay for so long: 0.001 to 60 s.
bool may_stay(double seconds);

/// Writes the pictures (of one size, CV_8UC3) as one file that plays for ever, atomically. Throws
/// std::invalid_argument without pictures, for sizes that differ and for a time in which none may stay;
/// std::runtime_error names the file and the reason.
void save_animation(const FilePlace& file, const std::vector<cv::Mat>& pictures, double seconds_a_picture);

}  // namespace lcmslam
