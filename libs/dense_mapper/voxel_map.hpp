#pragma once
// The growing map that frames are registered against: surfels (mean point, mean normal) in voxels,
// voxels in blocks of 4x4x4, blocks in a hash table. Cost of a look-up does not depend on the size
// of the map; memory is bounded: when the blocks become too many, the farthest ones are forgotten.
//
// Invariant: every surfel lies in the voxel that it is filed under, with a finite unit normal.

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/cloud/voxel_index.hpp>
#include <lcmslam/dense_mapper/free_space.hpp>
#include <lcmslam/registration/target.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct VoxelMapSettings {
  double voxel_size = 0.04;
  double normal_agreement = 0.5;
  double max_weight = 60;
  int min_observations = 1;
  int settled_after = 8;
  // Evidence that a surfel is still there: 1 when it is new; a view that supports it adds one.
  int max_evidence = 6;
  int miss = 2;
  int dropped_at = -3;
  int max_blocks = 160000;

  void describe(SettingsVisitor& s) {
    s.number("voxel_size", voxel_size, "m", {0.001, 10}, "of the map that frames are registered to");
    s.number("normal_agreement", normal_agreement, "", {-1, 1},
             "cosine; points in a voxel whose normals differ by more make a second surfel");
    s.number("max_weight", max_weight, "", {1, 1e6},
             "observations that a surfel remembers; then it is a running mean");
    s.number("min_observations", min_observations, "", {1, 30000},
             "frames that must have shown a surfel, once so many have joined the map since it was seen last");
    s.number("settled_after", settled_after, "", {1, 30000},
             "frames that must have shown a surfel, as the robot passes it by 10 cm or more, before it leads "
             "others, where wheels tell the way: what goes ahead of the robot is young wherever it is");
    s.number("max_evidence", max_evidence, "", {1, 100},
             "that a surfel is still there; bounded, so that what has long been there can go, too");
    s.number("miss", miss, "", {1, 100}, "evidence that a view takes off what it sees through");
    s.number("dropped_at", dropped_at, "", {-100, -1}, "evidence at which a surfel goes");
    s.number(
        "max_blocks", max_blocks, "", {100, 1e8},
        "of 4x4x4 voxels, the farthest are forgotten first (about 1.2 kB each where surfaces fill them)");
  }
};

class VoxelMap : public Target {
 public:
  explicit VoxelMap(const VoxelMapSettings& settings = {});

  /// Merges a cloud in map coordinates; points without a normal are left out. `T_map_view` is where it was
  /// seen from: what is farthest from there is forgotten first, and what stays where it is in that view,
  /// while the view moves, is young. New surfels belong to keyframe `anchor`.
  void insert(const Cloud& cloud, const Eigen::Isometry3d& T_map_view, int anchor = 0);

  /// Keyframes get other numbers: surfels of `i` belong to number[i] now, those of later ones to its last.
  void renumber_anchors(const std::vector<int>& number);

  /// The map after its keyframes have moved: each surfel goes with the one it belongs to, by
  /// T_new_old[anchor], those of later ones with the last. Surfels that meet in a voxel become one.
  VoxelMap deformed(const std::vector<Eigen::Isometry3d>& T_new_old) const;

  struct Gone {
    Eigen::Vector3f point;  ///< m, map
    int anchor = 0;         ///< keyframe that it belonged to
  };
  /// Surfels that the view supports gain, those that it sees through lose evidence; the ones that have lost
  /// enough go and are given back. Follows a rotating share of the view's rays (one of rotation^2), so that
  /// the cost does not depend on the map's size. `turn` counts the calls. Surfels of nodes before
  /// `first_node` stay as they are.
  std::vector<Gone> look_through(const FreeSpaceView& view, const Eigen::Isometry3d& T_map_camera,
                                 const FreeSpaceSettings& settings, std::int32_t turn, int first_node = 0);

  /// Surfels that were seen through of late are no partners.
  bool find(const Eigen::Vector3f& point, float max_distance, TargetPoint& found) const override;
  bool finds_nearest() const override { return true; }
  bool find_nearest(const Eigen::Vector3f& point, float max_distance, TargetPoint& found,
                    float& others) const override;
  /// Of about `asked` points of a cloud (map coordinates), how many lie on surfels of each keyframe, by its
  /// number; with normals, on surfels that face the same way.
  std::vector<int> owners(const Cloud& cloud, std::size_t asked) const;
  std::size_t size() const override { return surfels_; }
  std::size_t blocks() const { return blocks_.size(); }
  std::size_t memory_bytes() const;
  /// Whether clouds with intensities were inserted: then partners have them, with their gradient.
  bool has_intensities() const { return intensities_; }
  /// Whether something was forgotten since the map began.
  bool has_forgotten() const { return forgotten_; }

  /// Counts insertions, deformations and views that took surfels away: the same number, the same surfels.
  std::int32_t revision() const { return frame_; }

  /// All surfels, in an order that depends only on what was inserted.
  Cloud cloud() const;
  /// Those that find() gives, less than `radius` (m) from `centre` (map coordinates).
  Cloud partners_around(const Eigen::Vector3d& centre, double radius) const;

 private:
  /// Where something is in a view, to 2 cm, again and again after 256 of them: small to keep, and enough to
  /// see that it has moved there.
  using PlaceInView = std::array<std::uint8_t, 3>;
  static PlaceInView place_in_view(const Eigen::Vector3f& point);

  struct Surfel {
    Eigen::Vector3f point;
    Eigen::Vector3f normal;
    float weight;     // sum of 1 / sigma^2
    float sigma;      // of one observation, m
    float intensity;  // 0..1, NaN where unknown
    std::int16_t observations;
    std::int8_t cell;      // voxel in the block, 0..63
    std::int8_t evidence;  // that it is still there; below 0 it is doubtful
    std::int32_t frame;    // last insertion that touched it
    std::int32_t anchor;   // keyframe that it moves with
    PlaceInView first_seen;
    bool passed = false;  // the view has moved against it since: it does not go with the robot
  };
  struct Block {
    Eigen::Vector3i position;
    std::int32_t looked_at = -1;  // turn
    std::vector<Surfel> surfels;
  };

  bool is_partner(const Surfel& s) const {
    return (s.observations >= settings_.min_observations || s.frame >= recent_from_) && s.evidence >= 0;
  }
  bool is_young(const Surfel& s) const { return s.observations < settings_.settled_after || !s.passed; }
  void append(const Surfel& s, Cloud& cloud) const;
  Block& block_at(const Eigen::Vector3i& position);
  void merge(const Surfel& seen);
  float sigma_of_mean(const Surfel& surfel) const;
  Eigen::Vector3f gradient_at(const Surfel& surfel, const Block& block) const;
  void look_at(Block& block, const FreeSpaceView& view, const Eigen::Isometry3f& T_camera_map, int first_node,
               std::vector<Gone>& gone) const;
  void forget(const Eigen::Vector3d& view_point);

  VoxelMapSettings settings_;
  float inverse_size_;
  VoxelIndex index_;
  std::vector<Block> blocks_;
  std::size_t surfels_ = 0;
  bool forgotten_ = false, intensities_ = false;
  std::int32_t frame_ = 0;
  std::deque<std::int32_t> insertions_;  // the last min_observations of them
  std::int32_t recent_from_ = 0;         // what these touched had no time to be seen again
};

}  // namespace lcmslam
