#include "procs/map-server/keyframe_features.hpp"

#include <algorithm>
#include <cstdlib>

#include <lcmslam/messages/feature_messages.hpp>

namespace lcmslam {
namespace {

constexpr Utime longest_apart = 17'000;        // us, at 30 Hz
constexpr std::size_t most_kept_frames = 100;  // frames
constexpr std::size_t most_without = 32;       // that wait

bool are_of(const features_t& features, Utime utime) {
  return std::abs(features.utime - utime) <= longest_apart;
}

std::optional<FeatureFrame> readable(const features_t& message) {
  try {
    return from_message(message);
  } catch (const DecodeError&) {
    return std::nullopt;
  }
}

}  // namespace

std::optional<KeyframeFeatures::Found> KeyframeFeatures::keyframe(const Keyframe& keyframe) {
  const auto away = [&](const features_t& f) { return std::abs(f.utime - keyframe.utime); };
  const auto nearest =
      std::min_element(recent_.begin(), recent_.end(),
                       [&](const features_t& a, const features_t& b) { return away(a) < away(b); });
  if (nearest != recent_.end() && are_of(*nearest, keyframe.utime)) {
    auto features = readable(*nearest);
    if (!features) return std::nullopt;
    return Found{keyframe, std::move(*features)};
  }
  waiting_.push_back(keyframe);
  if (waiting_.size() > most_without) waiting_.pop_front();
  return std::nullopt;
}

std::vector<KeyframeFeatures::Found> KeyframeFeatures::features(const features_t& message) {
  recent_.push_back(message);
  if (recent_.size() > most_kept_frames) recent_.pop_front();
  std::vector<Found> found;
  const auto waits_no_more = [&](const Keyframe& keyframe) {
    if (!are_of(message, keyframe.utime)) return false;
    if (auto features = readable(message)) found.push_back({keyframe, std::move(*features)});
    return true;
  };
  waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(), waits_no_more), waiting_.end());
  return found;
}

std::optional<FeatureFrame> KeyframeFeatures::at(Utime utime) const {
  if (recent_.empty()) return std::nullopt;
  if (utime == 0) return readable(recent_.back());
  const auto then =
      std::find_if(recent_.begin(), recent_.end(), [&](const features_t& f) { return f.utime == utime; });
  return then != recent_.end() ? readable(*then) : std::nullopt;
}

}  // namespace lcmslam
