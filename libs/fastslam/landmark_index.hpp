#pragma once
// What all particles share about landmarks: identity, descriptor, existence. One index for all of them
// makes correspondences known (thesis 2.3: the global descriptor tree); each particle's map holds only
// Gaussians, found by slot. A slot whose landmark died is used again under a new id.

#include <cstdint>
#include <vector>

#include "fastslam/settings.hpp"
#include "surf/feature.hpp"

namespace lcmslam {

struct LandmarkRecord {
  std::int64_t id = -1;  ///< never used twice; -1: free slot
  std::array<std::uint8_t, 3> colour{};
  std::int8_t laplacian = 0;
  int observations = 0;
  int unseen_steps = 0;                                 ///< since the last sight
  double log_odds = 0;                                  ///< of existing
  Eigen::Vector3d seen_from = Eigen::Vector3d::Zero();  ///< unit, world, landmark to camera, last sight
  double seen_at = 0;                                   ///< m, range of the last sight
};

class LandmarkIndex {
 public:
  /// A slot for a new landmark.
  int add(const Feature& feature, const FastSlamSettings& settings);
  void observe(int slot, const Feature& feature, const FastSlamSettings& settings);
  /// Expected and not seen. True when the landmark died by it; its slot is free then.
  bool miss(int slot, const FastSlamSettings& settings);

  /// Ages all landmarks by a step; returns how many were forgotten (never well established, long unseen).
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
  std::int64_t next_id_ = 1;
};

}  // namespace lcmslam
