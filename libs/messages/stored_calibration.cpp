#include <lcmslam/messages/stored_calibration.hpp>

#include <algorithm>

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>

namespace lcmslam {

StoredCalibration stored(const camera_calibration_t& message) {
  camera_calibration_t lasting = message;
  lasting.utime = lasting.seq = lasting.sender = 0;
  return {message.sensor, camera_calibration_t::getTypeName(), encode_message(lasting)};
}

RgbdCalibration from_stored(const StoredCalibration& calibration) {
  const std::vector<std::uint8_t>& bytes = calibration.bytes;
  return from_message(decode_message<camera_calibration_t>(bytes.data(), bytes.size()));
}

KnownCalibrations::Calibration KnownCalibrations::same_as(const RgbdCalibration& calibration) {
  constexpr std::size_t most = 16;
  const auto is_it = [&](const Calibration& known) { return reads_alike(*known, calibration); };
  if (const auto found = std::find_if(known_.begin(), known_.end(), is_it); found != known_.end())
    return *found;
  known_.push_front(std::make_shared<RgbdCalibration>(calibration));
  if (known_.size() > most) known_.pop_back();
  return known_.front();
}

KnownCalibrations::Calibration KnownCalibrations::of(const StoredImages& images) {
  if (!images.calibration) return nullptr;
  try {
    return same_as(from_stored(*images.calibration));
  } catch (const DecodeError&) {
    return nullptr;
  }
}

}  // namespace lcmslam
