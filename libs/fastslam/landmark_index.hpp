#pragma once
// What all particles share about landmarks: identity, descriptor, existence. One index for all of them
// makes correspondences known (thesis 2.3: the global descriptor tree); each particle's map holds only
// Gaussians, found by slot. A slot whose landmark died is used again under a new id.

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "fastslam/settings.hpp"
#include "surf/feature.hpp"

namespace lcmslam {

struct LandmarkRecord {
  /// -1: free slot. A known identity keeps its number; others count from kFirstOwnId, never used twice.
  std::int64_t id = -1;
  std::int32_t known_id = -1;  ///< identity that the sensor told; -1: known by its descriptor
  std::array<std::uint8_t, 3> colour{};
  std::int8_t laplacian = 0;
  int observations = 0;
  int unseen_steps = 0;                                 ///< since the last sight
  Utime measured = 0;                                   ///< time of the last measurement used
  double log_odds = 0;                                  ///< of existing
  Eigen::Vector3d seen_from = Eigen::Vector3d::Zero();  ///< unit, world, landmark to camera, last sight
  double seen_at = 0;                                   ///< m, range of the last sight
};

/// Below it ids are known identities, which are 32-bit numbers.
constexpr std::int64_t kFirstOwnId = std::int64_t{1} << 31;

class LandmarkIndex {
 public:
  /// A slot for a new landmark.
  int add(const Feature& feature, const FastSlamSettings& settings);
  void observe(int slot, const Feature& feature, const FastSlamSettings& settings);
  /// Expected and not seen. True when the landmark died by it; its slot is free then.
  bool miss(int slot, const FastSlamSettings& settings);

  /// Slot of a known identity; -1 when it has no landmark.
  int find(std::int32_t known_id) const;

  /// Ages all landmarks by a step; returns how many were forgotten: never well established, long unseen,
  /// and of no known identity.
  int age(const FastSlamSettings& settings);

  /// Slots ever used; some may be free.
  int slots() const { return static_cast<int>(records_.size()); }
  /// Living landmarks.
  int size() const { return slots() - static_cast<int>(free_.size()); }
  bool alive(int slot) const { return record(slot).id >= 0; }
  const LandmarkRecord& record(int slot) const { return records_[static_cast<std::size_t>(slot)]; }
  LandmarkRecord& record(int slot) { return records_[static_cast<std::size_t>(slot)]; }
  const Descriptor& descriptor(int slot) const { return descriptors_[static_cast<std::size_t>(slot)]; }

 private:
  void release(int slot);

  std::vector<LandmarkRecord> records_;
  std::vector<Descriptor> descriptors_;  // apart: searches stream through them
  std::vector<int> free_;
  std::unordered_map<std::int32_t, int> known_slots_;
  std::int64_t next_id_ = kFirstOwnId;
};

}  // namespace lcmslam
