#pragma once
// Pictures as the bytes of PNG files (W3C, PNG third edition). Written here and not through OpenCV's codecs:
// their library loads 150 others (GDAL and all that it knows), most of the time that the map server took to
// start.

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

namespace lcmslam {

/// Throws std::invalid_argument unless the picture is CV_8UC3 and not empty.
std::string encode_png(const cv::Mat& picture);

/// What encode_png puts together, for other files of such chunks.
std::string png_signature();
std::string png_header(const cv::Size& size);   ///< data of IHDR: eight bits of R, G and B
std::string png_image(const cv::Mat& picture);  ///< data of IDAT
std::string png_chunk(const std::string& type, const std::string& data);
std::string big_endian(std::uint32_t number, int bytes = 4);

}  // namespace lcmslam
