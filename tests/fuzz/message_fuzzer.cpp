// Any bytes as a message: the first byte chooses a type, whose fingerprint is put before the rest, or (from
// 128) leaves the rest as it came. What decodes encodes to the same bytes again.

#include <cstdlib>
#include <functional>

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/messages/origin.hpp>
#include <lcmslam/messages/parts.hpp>
#include <lcmslam/messages/print_message.hpp>
#include "message_includes.inc"

namespace lcmslam {
namespace {

using Bytes = std::vector<std::uint8_t>;

void require(bool condition) {
  if (!condition) std::abort();
}

/// A head that is as small as the seeds' images.
const RgbdCalibration& calibration() {
  static const RgbdCalibration value = [] {
    RgbdCalibration c;
    c.colour.width = 16, c.colour.height = 12;
    c.depth.width = 8, c.depth.height = 6;
    c.colour.fx = c.colour.fy = c.depth.fx = c.depth.fy = 20;
    return c;
  }();
  return value;
}

// What consumers do with a message beyond decoding it.
template <class M>
void convert(const M&) {}
void convert(const images_t& m) {
  from_message(m);
  decode_images(m, calibration());
}
void convert(const camera_calibration_t& m) {
  same_calibration(m, to_message(from_message(m)));
}
void convert(const features_t& m) {
  for (const Feature& f : from_message(m).features)
    require(f.kind == MeasurementKind::bearing || f.point.allFinite());
}
void convert(const encoders_t& m) {
  from_message(m);
}
void convert(const odometry_t& m) {
  require(from_message(m).T_odom_robot.matrix().allFinite());
}
void convert(const pose_estimate_t& m) {
  require(from_message(m.T_map_robot, "T_map_robot").matrix().allFinite());
  require(covariance_from_message(m.covariance, "covariance").allFinite());
}
void convert(const ground_truth_t& m) {
  require(from_message(m.T_frame_child, "T_frame_child").matrix().allFinite());
}
void convert(const landmarks_t& m) {
  LandmarkMap map;
  map.apply({m.map_revision, m.base_revision, landmarks_of(m), m.removed});
  map.add_tile({m.map_revision, m.tile, m.n_tiles, landmarks_of(m)});
}
void convert(const keyframe_t& m) {
  DenseMap map;
  map.add(from_message(m));
  map.merge(0.05);
}
void convert(const part_t& m) {
  PartAssembler().add(m);
}

template <class M>
void consume(const Bytes& bytes) {
  const M message = decode_message<M>(bytes.data(), bytes.size());
  require(encode_message(message) == bytes);
  (void)origin(message);
  convert(message);
}

struct Consumer {
  std::uint64_t fingerprint;
  void (*consume)(const Bytes&);
};

const std::vector<Consumer>& consumers() {
#define MESSAGE_TYPE(M) {static_cast<std::uint64_t>(M::getHash()), consume<M>},
  static const std::vector<Consumer> all = {
#include "message_types.inc"
  };
#undef MESSAGE_TYPE
  return all;
}

void refused_or_read(const std::function<void()>& read) {
  try {
    read();
  } catch (const DecodeError&) {
  }
}

std::uint64_t fingerprint_of(const Bytes& bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < 8 && i < bytes.size(); ++i) value = (value << 8) | bytes[i];
  return value;
}

}  // namespace
}  // namespace lcmslam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcmslam;
  if (size == 0) return 0;
  Bytes bytes;
  if (data[0] < 128) {
    const std::uint64_t fingerprint = consumers()[data[0] % consumers().size()].fingerprint;
    for (int shift = 56; shift >= 0; shift -= 8)
      bytes.push_back(static_cast<std::uint8_t>(fingerprint >> shift));
  }
  bytes.insert(bytes.end(), data + 1, data + size);
  bytes.shrink_to_fit();  // so that the sanitizer sees whoever reads on

  const std::uint64_t fingerprint = fingerprint_of(bytes);
  for (const Consumer& consumer : consumers())
    if (consumer.fingerprint == fingerprint || data[0] >= 250)
      refused_or_read([&] { consumer.consume(bytes); });
  if (const MessageType* type = MessageType::find(fingerprint))
    refused_or_read([&] {
      const MessageValue value = read_message(*type, bytes.data(), bytes.size());
      print_message(value);
      message_json(value);
    });
  return 0;
}
