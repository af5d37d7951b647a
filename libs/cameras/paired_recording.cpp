#include <lcmslam/cameras/paired_recording.hpp>

namespace lcmslam {

/// Whether `recording` is to be read next: the one whose last image is older.
bool PairedRecording::is_behind(const Recording& recording, const Recording& other) const {
  if (recording.device->ended()) return false;
  if (other.device->ended() || !recording.begun) return true;
  return other.begun && recording.last <= other.last;
}

std::optional<CameraShot> PairedRecording::read(std::chrono::milliseconds patience) {
  while (true) {
    if (auto pair = pairs_.next()) return pair;
    if (ended_) return std::nullopt;
    Recording& next = is_behind(colour_, depth_) ? colour_ : depth_;
    if (auto frame = next.device->read(patience)) {
      next.begun = true;
      next.last = &next == &colour_ ? frame->utime : pairs_.depth_time(*frame);
      if (&next == &colour_)
        pairs_.add_colour(std::move(*frame));
      else
        pairs_.add_depth(std::move(*frame));
    } else if (!next.device->ended()) {
      return std::nullopt;  // slow
    }
    ended_ = colour_.device->ended() && depth_.device->ended();
    if (ended_) pairs_.finish();
  }
}

}  // namespace lcmslam
