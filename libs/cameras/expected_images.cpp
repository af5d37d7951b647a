#include <lcmslam/cameras/expected_images.hpp>

namespace lcmslam {
namespace {

std::string in_words(cv::Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

std::string wrong_size(const char* name, const cv::Mat& image, cv::Size expected) {
  if (expected.area() == 0 || image.size() == expected) return "";
  if (image.empty()) return std::string("the ") + name + " image is missing";
  return std::string("the ") + name + " image is " + in_words(image.size()) +
         ", by its calibration it must be " + in_words(expected);
}

}  // namespace

std::string misfit(const RgbdFrame& frame, const ExpectedImages& expected) {
  const std::string colour = wrong_size("colour", frame.colour, expected.colour);
  return colour.empty() ? wrong_size("depth", frame.depth, expected.depth) : colour;
}

}  // namespace lcmslam
