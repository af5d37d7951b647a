#pragma once
// The landmark map as others see it: whole, or what changed since the last time. When another particle
// becomes the best, only landmarks that really differ go out.

#include <cstdint>
#include <functional>
#include <vector>

#include <lcmslam/fastslam/landmarks/landmark_index.hpp>
#include <lcmslam/fastslam/landmarks/particle_map.hpp>
#include <lcmslam/features/landmark.hpp>

namespace lcmslam {

struct MapChanges {
  std::int64_t revision = 0;          ///< counts calls that changed something
  std::vector<Landmark> changed;      ///< new ones too; ordered by slot
  std::vector<std::int64_t> removed;  ///< ids
};

/// The landmark of a slot that is alive.
Landmark make_public(int slot, const ParticleMap& map, const LandmarkIndex& index);

class LandmarkPublication {
 public:
  /// A landmark goes out again when its mean moved by `tolerance` (m) or its variance by half.
  explicit LandmarkPublication(int minimum_observations, double tolerance = 0.005)
      : minimum_observations_(minimum_observations), tolerance_(tolerance) {}

  /// `published`: the landmark of a slot as others shall see it. Cost: what changed since the last call, not
  /// the map.
  MapChanges take(const ParticleMap& map, LandmarkIndex& index,
                  const std::function<Landmark(int)>& published);

 private:
  struct Sent {
    std::int64_t id = -1;
    CompactLandmark landmark;
  };
  bool differs(const Sent& sent, const CompactLandmark& now) const;

  int minimum_observations_;
  double tolerance_;
  ParticleMap compared_;  // shares its nodes with the map of the last call: equal parts are skipped
  std::vector<Sent> sent_;
  std::int64_t revision_ = 0;
};

}  // namespace lcmslam
