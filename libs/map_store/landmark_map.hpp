#pragma once
// The landmarks of one mapper, kept up to date from its changes.
//
// A change leads from a base revision to a new one. When one was missed the map is `incomplete`: its
// owner asks the mapper for the whole map, which arrives in tiles, in any order, while further
// changes keep coming.

#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include <lcmslam/features/landmark.hpp>

namespace lcmslam {

/// base_revision 0 starts from the empty map, whatever was there (a mapper that began anew).
struct LandmarkChange {
  std::int64_t revision = 0;
  std::int64_t base_revision = 0;
  std::vector<Landmark> upserted;
  std::vector<std::int64_t> removed;
};

/// Part `tile` (from 0) of the `tiles` parts that make the whole map of one revision.
struct LandmarkTile {
  std::int64_t revision = 0;
  int tile = 0;
  int tiles = 1;
  std::vector<Landmark> landmarks;
};

class LandmarkMap {
 public:
  /// At most so many landmarks: messages may not make more.
  explicit LandmarkMap(std::size_t most_landmarks = 300'000) : most_landmarks_(most_landmarks) {}

  /// Applies the change; one that is already contained is left out. A change on another base is
  /// applied as far as it goes and leaves the map incomplete. Returns !incomplete(). Throws
  /// std::invalid_argument where the map would hold too many landmarks.
  bool apply(const LandmarkChange& change);

  /// Keeps the tile; the last missing one replaces the whole map, then changes that came meanwhile
  /// follow. Tiles of a revision that a complete map already has are left out. Returns whether the
  /// map was replaced. Throws std::invalid_argument for impossible tile numbers.
  bool add_tile(const LandmarkTile& tile);

  /// Empty, revision 0, complete.
  void clear();

  /// Changes were missed: ask for the whole map.
  bool incomplete() const { return incomplete_; }
  std::int64_t revision() const { return revision_; }
  std::size_t size() const { return landmarks_.size(); }
  /// nullptr when there is none.
  const Landmark* find(std::int64_t id) const;
  /// Ordered by id.
  std::vector<Landmark> landmarks() const;
  /// The first that have a higher id than that, at most so many.
  std::vector<Landmark> after(std::int64_t id, std::size_t most) const;

 private:
  void put(const LandmarkChange& change);
  bool contained(const LandmarkChange& change) const;

  void check_room(std::size_t landmarks) const;

  std::size_t most_landmarks_;
  std::map<std::int64_t, Landmark> landmarks_;
  std::int64_t revision_ = 0;
  bool incomplete_ = false;

  std::int64_t pending_revision_ = 0;
  std::size_t pending_tiles_ = 0;  ///< 0: no replacement under way
  std::map<int, std::vector<Landmark>> pending_;
  std::deque<LandmarkChange> recent_;  ///< the last changes, to follow a replacement that is older
};

}  // namespace lcmslam
