#pragma once
// Finds for each keyframe the features of its moment: those of the frame that is nearest to it, within half
// the time between two frames, whichever of them comes first.

#include <deque>
#include <optional>
#include <vector>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/features_t.hpp>
#include "procs/map-server/session_table.hpp"

namespace lcmslam {

class KeyframeFeatures {
 public:
  struct Keyframe {
    SessionKey key;
    std::int32_t id = 0;
    Utime utime = 0;
  };
  struct Found {
    Keyframe keyframe;
    FeatureFrame features;
  };

  /// Those that have come already; else the keyframe waits for them.
  std::optional<Found> keyframe(const Keyframe& keyframe);
  /// Of keyframes that waited for these. Features that cannot be read are left out.
  std::vector<Found> features(const features_t& message);

  /// That were taken then (0: the newest that were heard); nothing where they did not come or are gone.
  std::optional<FeatureFrame> at(Utime utime) const;

 private:
  std::deque<features_t> recent_;
  std::deque<Keyframe> waiting_;
};

}  // namespace lcmslam
