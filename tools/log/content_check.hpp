#pragma once
// The checks that the nodes make of what they take, for logs: values, and the bytes of images.

#include <optional>
#include <string>
#include <string_view>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/messages/schema.hpp>

namespace lcmslam {

class ContentCheck {
 public:
  /// Why a node would refuse the message; empty: none would, or none takes messages of this type. Images of
  /// CAMERA are decoded and must be of the size that the last sound CAMERA_CALIBRATION says.
  std::string problem(std::string_view channel, const std::uint8_t* data, std::size_t size);

 private:
  void check(std::string_view channel, const MessageType& type, const std::uint8_t* data, std::size_t size);
  void check_images(const std::uint8_t* data, std::size_t size);

  std::optional<RgbdCalibration> calibration_;
};

}  // namespace lcmslam
