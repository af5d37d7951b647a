#pragma once
// A calibration file of a head whose images have the sizes that a test gives them, and images to tell apart.

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>

namespace lcmslam::testing {

/// Below the temporary folder; removed with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "lcmslam-cameras-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error(pattern + ": cannot be made");
    path_ = pattern;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  std::string text() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

inline std::string camera_text(cv::Size size) {
  return "{width: " + std::to_string(size.width) + ", height: " + std::to_string(size.height) +
         ", fx: 200, fy: 200, cx: 80, cy: 70}\n";
}

/// Registered when the sizes say so: an empty depth size.
inline void write_head(const std::filesystem::path& file, cv::Size colour, cv::Size depth = {}) {
  std::ofstream out(file);
  out << "sensor: mine\ncolour: " << camera_text(colour);
  if (depth.area() == 0)
    out << "depth_registered: true\n";
  else
    out << "depth: " << camera_text(depth)
        << "colour_depth: {translation: [0, 0, 0], quaternion: [1, 0, 0, 0]}\n";
}

/// Colour images that differ in each pixel and number, smooth enough for JPEG.
inline cv::Mat numbered_colour(cv::Size size, int number) {
  cv::Mat image(size, CV_8UC3);
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u)
      image.at<cv::Vec3b>(v, u) = {static_cast<std::uint8_t>(40 + 100 * u / size.width),
                                   static_cast<std::uint8_t>(40 + 100 * v / size.height),
                                   static_cast<std::uint8_t>(20 + 5 * number % 200)};
  return image;
}

inline cv::Mat numbered_depth(cv::Size size, int number) {
  cv::Mat image(size, CV_16UC1);
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u)
      image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(1000 + 10 * number + 3 * u + v);
  return image;
}

inline double largest_difference(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() ? cv::norm(a, b, cv::NORM_INF) : 1e9;
}

}  // namespace lcmslam::testing
