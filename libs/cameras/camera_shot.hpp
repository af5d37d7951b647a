#pragma once
// What a camera gave: images decoded, or the colour image still as the JPEG that the camera made, which goes
// on as it is: coding it again would cost time and sharpness.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <lcmslam/imaging/rgbd_frame.hpp>

namespace lcmslam {

struct CameraShot : RgbdFrame {
  CameraShot() = default;
  CameraShot(RgbdFrame frame) : RgbdFrame(std::move(frame)) {}

  std::vector<std::uint8_t> jpeg;  ///< of the colour image, where `colour` is empty
  cv::Size jpeg_size;              ///< pixels, by its header
  std::string damage;              ///< why the colour image's bytes are none; empty: nothing is wrong

  cv::Size colour_size() const { return jpeg.empty() ? colour.size() : jpeg_size; }
};

}  // namespace lcmslam
