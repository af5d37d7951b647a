#include "tools/log/content_check.hpp"

#include <functional>
#include <map>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include "tools/log/message_facts.hpp"

namespace lcmslam {
namespace {

using Check = std::function<void(const std::uint8_t*, std::size_t)>;

/// A check that throws DecodeError, by the type that it reads.
template <class M, class Read>
std::pair<const std::uint64_t, Check> of_type(const Read& read) {
  return {static_cast<std::uint64_t>(M::getHash()),
          [read](const std::uint8_t* data, std::size_t size) { read(decode_message<M>(data, size)); }};
}

const std::map<std::uint64_t, Check>& checks() {
  static const std::map<std::uint64_t, Check> all = {
      of_type<encoders_t>([](const encoders_t& m) { from_message(m); }),
      of_type<twist_t>([](const twist_t& m) { from_message(m); }),
      of_type<odometry_t>([](const odometry_t& m) { from_message(m); }),
      of_type<pose_t>([](const pose_t& m) { from_message(m); }),
      of_type<features_t>([](const features_t& m) { from_message(m); }),
      of_type<landmarks_t>([](const landmarks_t& m) { landmarks_of(m); }),
      of_type<keyframe_t>([](const keyframe_t& m) { from_message(m); }),
      of_type<graph_t>([](const graph_t& m) { from_message(m); }),
      of_type<pose_estimate_t>([](const pose_estimate_t& m) { from_message(m.T_map_robot, "T_map_robot"); }),
      of_type<ground_truth_t>(
          [](const ground_truth_t& m) { from_message(m.T_frame_child, "T_frame_child"); }),
  };
  return all;
}

}  // namespace

std::string ContentCheck::problem(std::string_view channel, const std::uint8_t* data, std::size_t size) {
  const MessageType* type = message_type(data, size);
  if (type == nullptr) return "";
  try {
    check(channel, *type, data, size);
  } catch (const DecodeError& error) {
    return error.what();
  }
  return "";
}

void ContentCheck::check(std::string_view channel, const MessageType& type, const std::uint8_t* data,
                         std::size_t size) {
  static const auto calibrations = static_cast<std::uint64_t>(camera_calibration_t::getHash());
  if (channel == "CAMERA") return check_images(data, size);
  if (type.fingerprint == calibrations) {
    const RgbdCalibration calibration = from_message(decode_message<camera_calibration_t>(data, size));
    if (channel == "CAMERA_CALIBRATION") calibration_ = calibration;
    return;
  }
  const auto found = checks().find(type.fingerprint);
  if (found != checks().end()) found->second(data, size);
}

void ContentCheck::check_images(const std::uint8_t* data, std::size_t size) {
  const auto message = decode_message<images_t>(data, size);
  if (calibration_) {
    decode_images(message, *calibration_);
    return;
  }
  try {
    decode(from_message(message));
  } catch (const CodecError& error) {
    throw DecodeError(error.what());
  }
}

}  // namespace lcmslam
