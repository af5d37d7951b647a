#pragma once
// The dense map: coloured clouds on keyframes. The clouds stay in their camera's frame, so when the
// pose graph is corrected the map deforms with it.

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

struct DenseKeyframe {
  std::int32_t id = 0;
  Utime utime = 0;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  ColouredCloud cloud;        ///< camera frame; sigmas are not kept
  std::int64_t revision = 0;  ///< of its cloud as published: tiles of one publication agree, others differ
};

/// Part `tile` (from 0) of `tiles` of a keyframe's cloud; every tile carries the pose.
struct KeyframeTile {
  DenseKeyframe part;
  int tile = 0;
  int tiles = 1;
};

struct KeyframePose {
  std::int32_t id = 0;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
};

/// What messages may make of a map at most.
struct DenseMapLimits {
  std::size_t keyframes = 10'000;
  std::size_t points = 20'000'000;
  std::size_t incomplete = 32;  ///< keyframes of which tiles are missing; then the oldest goes
};

class DenseMap {
 public:
  explicit DenseMap(const DenseMapLimits& limits = {}) : limits_(limits) {}

  /// Keeps the tile; the last missing one adds the keyframe or replaces it. Tiles come in any order
  /// and repeatedly; another revision, utime or number of tiles starts the keyframe anew. Returns whether
  /// the keyframe became complete. Throws std::invalid_argument for impossible tile numbers, a pose
  /// that is not finite, colours or normals that do not match the points, and beyond the limits.
  bool add(const KeyframeTile& tile);

  /// Moves keyframes; the pose that arrived last counts. Returns the ids of keyframes that are not
  /// here (ask for them again). Throws std::invalid_argument for a pose that is not finite.
  std::vector<std::int32_t> correct(const std::vector<KeyframePose>& poses);

  /// Moves all keyframes as a whole graph has them: those that it does not name go, because the mapper gave
  /// them up or has begun a new map. Throws as correct() does.
  void follow(const std::vector<KeyframePose>& graph);

  void remove(std::int32_t id);
  void clear();

  /// All points in the world frame, averaged in cells of `resolution` m (see VoxelAverage); 0: as they are.
  ColouredCloud merge(double resolution) const;
  /// All points in the world frame as they are, keyframe by keyframe.
  ColouredCloud merge_all() const;

  /// Complete keyframes, by id.
  const std::map<std::int32_t, DenseKeyframe>& keyframes() const { return keyframes_; }
  /// Ids of keyframes of which tiles are missing.
  std::vector<std::int32_t> incomplete() const;
  std::size_t point_count() const { return points_; }
  /// Incomplete keyframes that went because others came.
  std::int64_t given_up() const { return given_up_; }
  /// Bytes that clouds occupy, of incomplete keyframes too.
  std::size_t memory_bytes() const;
  /// Counts every visible change, so that viewers know when to redraw.
  std::int64_t revision() const { return revision_; }

 private:
  struct Pending {
    Utime utime = 0;
    std::int64_t revision = 0;
    Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
    std::size_t tiles = 0;
    std::int64_t begun = 0;
    std::map<int, ColouredCloud> clouds;
  };

  Pending& pending_for(const KeyframeTile& tile);
  void check_limits(const DenseKeyframe& part) const;
  std::size_t points_of(std::int32_t id) const;

  DenseMapLimits limits_;
  std::map<std::int32_t, DenseKeyframe> keyframes_;
  std::size_t points_ = 0;  // of all keyframes
  std::int64_t begun_ = 0, given_up_ = 0;
  std::map<std::int32_t, Pending> pending_;
  std::int64_t revision_ = 0;
};

}  // namespace lcmslam
