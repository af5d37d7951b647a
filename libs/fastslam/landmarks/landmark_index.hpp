#pragma once
// What all particles share about landmarks: identity, descriptor, existence. One index for all of them
// makes correspondences known (thesis 2.3: the global descriptor tree); each particle's map holds only
// Gaussians, found by slot. A slot whose landmark died is used again under a new id.

#include <cstdint>
#include <set>
#include <tuple>
#include <unordered_map>
#include <vector>

#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/features/descriptor_index.hpp>
#include <lcmslam/features/feature.hpp>

namespace lcmslam {

struct LandmarkRecord {
  /// -1: free slot. A known identity keeps its number; others count from first_own_id, never used twice.
  std::int64_t id = -1;
  std::int32_t known_id = -1;  ///< identity that the sensor reads; -1: known by its descriptor
  std::array<std::uint8_t, 3> colour{};
  std::int8_t laplacian = 0;
  int observations = 0;
  int seen_step = 0;   ///< of the last observation, see unseen_steps()
  Utime measured = 0;  ///< time of the last measurement used
  Utime born = 0;
  double log_odds = 0;                                  ///< of existing
  Eigen::Vector3d seen_from = Eigen::Vector3d::Zero();  ///< unit, world, landmark to camera, last observation
  double seen_at = 0;                                   ///< m, range of the last observation
};

/// Below it ids are known identities, which are 32-bit numbers.
constexpr std::int64_t first_own_id = std::int64_t{1} << 31;

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
  /// and of no known identity. Cost: those that are due, not the map.
  int age(const FastSlamSettings& settings);
  /// Steps since the last observation.
  int unseen_steps(int slot) const { return step_ - record(slot).seen_step; }

  /// Slots that were added, seen or set free since the last call, ascending.
  std::vector<int> take_touched();

  /// Slots ever used; some may be free.
  int slots() const { return static_cast<int>(records_.size()); }
  /// Living landmarks.
  int size() const { return slots() - static_cast<int>(free_.size()); }
  bool alive(int slot) const { return record(slot).id >= 0; }
  const LandmarkRecord& record(int slot) const { return records_[static_cast<std::size_t>(slot)]; }
  LandmarkRecord& record(int slot) { return records_[static_cast<std::size_t>(slot)]; }
  const Descriptor& descriptor(int slot) const {
    return record(slot).known_id >= 0 ? known_descriptors_.at(slot) : search_.descriptor(slot);
  }
  /// The descriptors of all living landmarks without a known identity, by slot.
  const DescriptorIndex& search() const { return search_; }

 private:
  void release(int slot);
  void touch(int slot);

  std::vector<LandmarkRecord> records_;
  DescriptorIndex search_;
  std::unordered_map<int, Descriptor> known_descriptors_;  // by slot; never sought
  std::vector<int> free_;
  std::unordered_map<std::int32_t, int> known_slots_;
  std::int64_t next_id_ = first_own_id;
  int step_ = 0;
  struct Due {
    int step, slot;
    std::int64_t id;
    bool operator<(const Due& o) const { return std::tie(step, slot, id) < std::tie(o.step, o.slot, o.id); }
  };
  std::set<Due> tentative_;  // when who is forgotten unless seen
  std::vector<int> touched_;
  std::vector<char> is_touched_;  // by slot
};

}  // namespace lcmslam
