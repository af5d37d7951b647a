#include "tools/log/play_source.hpp"

#include <cmath>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/messages/decode.hpp>
#include "tools/log/message_facts.hpp"

namespace lcmslam {

std::string frames_of(const std::set<std::string>& channels) {
  for (const char* channel : {"CAMERA", "FEATURES"})
    if (channels.count(channel) > 0) return channel;
  return "";
}

std::optional<PlayEvent> PlaySource::next() {
  while (const auto event = reader_.next()) {
    begins_ |= sessions_.begins(*event);
    const bool selected =
        channels_.count(std::string(event->channel)) > 0 && selection_.has_time(event->timestamp, first_);
    if (selected) return describe(*event);
  }
  return std::nullopt;
}

PlayEvent PlaySource::describe(const LogEventView& view) {
  PlayEvent play{view.copy(), message_utime(view.data, view.size).value_or(view.timestamp), {}, begins_};
  begins_ = false;
  if (view.channel == frames_)
    play.frame = frame_times(view, play.utime);
  else if (view.channel == "CAMERA_CALIBRATION")
    calibrate(view);
  return play;
}

std::vector<Utime> PlaySource::frame_times(const LogEventView& view, Utime utime) const {
  std::vector<Utime> times{utime};
  if (view.channel == "CAMERA") try {
      for (const auto& image : decode_message<images_t>(view.data, view.size).images)
        for (const Utime offset : {Utime{0}, depth_offset_})
          times.push_back(time_between(-offset, image.utime));
    } catch (const DecodeError&) {  // a camera of another type
    }
  return times;
}

void PlaySource::calibrate(const LogEventView& view) {
  try {
    const double offset = decode_message<camera_calibration_t>(view.data, view.size).depth_clock_offset;
    if (std::abs(offset) < 10) depth_offset_ = static_cast<Utime>(1e6 * offset);
  } catch (const DecodeError&) {  // of another type
  }
}

}  // namespace lcmslam
