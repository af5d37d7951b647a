#pragma once
// A small recording: camera at 10 Hz, calibration at 1 Hz, wheels at 50 Hz, a foreign channel.

#include <filesystem>
#include <fstream>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/encoders_t.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/origin.hpp>
#include <lcmslam/messages/parts.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam::testing {

using Bytes = std::vector<std::uint8_t>;

inline Bytes camera_message(Utime utime, std::int64_t seq, Utime depth_after = 0, std::size_t size = 300) {
  images_t m;
  m.utime = utime;
  m.n_images = 2;
  m.image_types = {images_t::LEFT, images_t::DEPTH_MM};
  m.images.resize(2);
  for (std::size_t i = 0; i < 2; ++i) {
    image_t& image = m.images[i];
    image.utime = utime + (i == 1 ? depth_after : 0);
    image.width = static_cast<std::int32_t>(i == 0 ? size : size / 2);
    image.height = 1;
    image.row_stride = static_cast<std::int32_t>(size);
    image.nmetadata = 0;
    image.pixelformat = image_t::PIXEL_FORMAT_GRAY;
    if (i == 1) image.pixelformat = image_t::PIXEL_FORMAT_LE_GRAY16;
    image.data.assign(size, static_cast<std::uint8_t>(seq));
    image.size = static_cast<std::int32_t>(size);
  }
  set_origin(m, {seq, 77});
  return encode_message(m);
}

inline Bytes encoders_message(Utime utime, std::int64_t seq, std::int64_t sender = 77) {
  encoders_t m;
  m.utime = utime;
  m.seq = seq;
  m.sender = sender;
  wheel_t wheel{};
  wheel.radius = 0.1;
  m.wheels = {wheel, wheel};
  m.n_wheels = 2;
  return encode_message(m);
}

inline Bytes calibration_message(Utime utime, std::int64_t seq) {
  RgbdCalibration c;  // of the images above
  c.colour = {300, 1, 300, 300, 150, 0, {}};
  c.depth = {150, 1, 150, 150, 75, 0, {}};
  camera_calibration_t m = to_message(c);
  m.utime = utime;
  m.seq = seq;
  m.sender = 77;
  return encode_message(m);
}

inline Bytes foreign_message(std::uint8_t first) {
  return {first, 0x66, 0x6f, 0x72, 0x65, 0x69, 0x67, 0x6e, 1, 2, 3};
}

constexpr Utime sample_start = 1'000'000'000;

/// From `start` on (us).
inline void write_sample(LogWriter& log, double seconds, Utime start = sample_start) {
  std::int64_t frames = 0, readings = 0, calibrations = 0;
  for (int i = 0; i < static_cast<int>(seconds * 50); ++i) {
    const Utime now = start + 20'000 * i;
    if (i % 50 == 0) log.write(now, "CAMERA_CALIBRATION", calibration_message(now, calibrations++));
    log.write(now, "ENCODERS", encoders_message(now, readings++));
    if (i % 5 == 0) log.write(now + 1'000, "CAMERA", camera_message(now + 1'000, frames++));
    if (i % 25 == 0) log.write(now + 2'000, "ODD name, \xC3\xA4", foreign_message(0x11));
  }
}

inline std::string sample_log(const ScratchFolder& folder, double seconds,
                              const std::string& name = "a.lcmlog") {
  const std::string file = (folder.path() / name).string();
  LogWriter log(file);
  write_sample(log, seconds);
  log.close();
  return file;
}

inline std::vector<LogEvent> read_log(const std::string& file) {
  LogReader reader(file);
  std::vector<LogEvent> events;
  while (auto event = reader.next()) events.push_back(std::move(*event));
  return events;
}

inline std::size_t count(const std::vector<LogEvent>& events, const std::string& channel) {
  std::size_t n = 0;
  for (const auto& event : events) n += event.channel == channel ? 1 : 0;
  return n;
}

/// Changes one byte of a file.
inline void damage(const std::string& file, std::uint64_t offset, std::uint8_t flip = 1) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(offset));
  const int old = stream.get();
  stream.seekp(static_cast<std::streamoff>(offset));
  stream.put(static_cast<char>(old ^ flip));
}

/// The pieces of one message.
inline void write_pieces(LogWriter& log, Utime time, const std::string& channel, const Bytes& message,
                         std::int64_t number, std::int32_t missing = -1) {
  for (part_t part : split_message(channel, message, time, number, 200)) {
    part.sender = 5;
    part.seq = part.part;
    if (part.part != missing) log.write(time, part_channel(channel), encode_message(part));
  }
}

}  // namespace lcmslam::testing
