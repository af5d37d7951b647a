#include "tools/log/log_plausibility.hpp"

#include <optional>

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/rgbd/plausibility.hpp>
#include "tools/log/message_reader.hpp"

namespace lcmslam {
namespace {

constexpr std::int64_t looked_at = 12;  // frames

std::int64_t count_frames(const std::string& file) {
  MessageReader reader(file);
  std::int64_t frames = 0;
  while (const auto event = reader.next()) frames += event->channel == "CAMERA" ? 1 : 0;
  return frames;
}

}  // namespace

LogPlausibility plausibility_of_log(const std::string& file) {
  const std::int64_t frames = count_frames(file);
  const std::int64_t step = frames / looked_at + 1;
  std::optional<camera_calibration_t> said;
  std::optional<Plausibility> check;
  std::optional<RgbdCalibration> calibration;
  MessageReader reader(file);
  std::int64_t frame = 0;
  while (const auto event = reader.next()) {
    try {
      if (event->channel == "CAMERA_CALIBRATION") {
        const auto message = decode_message<camera_calibration_t>(event->data, event->size);
        if (said && same_calibration(*said, message)) continue;
        calibration = from_message(message);
        check.emplace(*calibration);
        said = message;
      } else if (event->channel == "CAMERA" && frame++ % step == 0 && check) {
        check->add(decode_images(decode_message<images_t>(event->data, event->size), *calibration));
      }
    } catch (const DecodeError&) {
      continue;  // the log's check counts these
    }
  }
  if (!check) return {};
  return {check->frames(), check->frames() > 0 ? check->depths().in_words() : "", check->findings()};
}

std::string format_plausibility(const LogPlausibility& plausibility) {
  std::string text;
  if (plausibility.frames > 0) text += "  depth images: " + plausibility.depths + "\n";
  for (const std::string& finding : plausibility.findings) text += "  looks wrong: " + finding + "\n";
  return text;
}

}  // namespace lcmslam
