#include <lcmslam/cameras/expected_images.hpp>

namespace lcmslam {
namespace {

std::string in_words(cv::Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

std::string wrong_size(const char* name, cv::Size size, cv::Size expected) {
  if (expected.area() == 0 || size == expected) return "";
  if (size.empty()) return std::string("the ") + name + " image is missing";
  return std::string("the ") + name + " image is " + in_words(size) + ", by its calibration it must be " +
         in_words(expected);
}

}  // namespace

std::string misfit(const CameraShot& frame, const ExpectedImages& expected) {
  if (!frame.damage.empty()) return "the colour image: " + frame.damage;
  const std::string colour = wrong_size("colour", frame.colour_size(), expected.colour);
  return colour.empty() ? wrong_size("depth", frame.depth.size(), expected.depth) : colour;
}

}  // namespace lcmslam
