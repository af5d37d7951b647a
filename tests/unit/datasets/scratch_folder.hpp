#pragma once
// A folder of a test's own, and small images to put in it.

#include <unistd.h>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>

namespace lcmslam::testing_files {

class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "lcmslam_datasets_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make a folder like " + name);
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::filesystem::path operator/(const std::string& file) const { return path_ / file; }
  const std::filesystem::path& path() const { return path_; }

  void write(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories((path_ / file).parent_path());
    std::ofstream(path_ / file, std::ios::binary) << text;
  }
  void write(const std::string& file, const cv::Mat& image) const {
    std::filesystem::create_directories((path_ / file).parent_path());
    if (!cv::imwrite((path_ / file).string(), image)) throw std::runtime_error("cannot write " + file);
  }
  std::string read(const std::string& file) const {
    std::ifstream stream(path_ / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

 private:
  std::filesystem::path path_;
};

constexpr int width = 32;
constexpr int height = 24;

inline cv::Mat colour_image(int number) {
  cv::Mat image(height, width, CV_8UC3);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      image.at<cv::Vec3b>(v, u) =
          cv::Vec3b(static_cast<std::uint8_t>(8 * u), static_cast<std::uint8_t>(8 * v),
                    static_cast<std::uint8_t>(40 + 10 * number));
  return image;
}

/// Value + column + row, with an unmeasured and a saturated pixel in the upper left corner.
inline cv::Mat depth_image(int value) {
  cv::Mat image(height, width, CV_16UC1);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(value + u + v);
  image.at<std::uint16_t>(0, 0) = 0;
  image.at<std::uint16_t>(0, 1) = 65535;
  return image;
}

inline const char* calibration_text() {
  return "sensor: small\n"
         "colour: {width: 32, height: 24, fx: 30, fy: 30, cx: 15.5, cy: 11.5}\n"
         "depth_registered: true\n";
}

}  // namespace lcmslam::testing_files
