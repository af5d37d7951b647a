#pragma once
// What is derived of a map on the board: surface, grid, planes and objects, each time as far as they have
// changed. Takes its time: a thread of its own is wanted where a map grows.

#include <memory>

#include <lcmslam/live_map/live_map.hpp>
#include <lcmslam/web/board.hpp>

namespace lcmslam {

class ShownLayers {
 public:
  explicit ShownLayers(Board& board) : board_(board) {}

  /// Another map takes the place of the one before. The grid lies around the robot; without a pose there is
  /// none.
  void show(const std::shared_ptr<const LiveMap>& map, const std::optional<Eigen::Isometry3d>& T_map_robot);

 private:
  void show_mesh();

  Board& board_;
  std::shared_ptr<const LiveMap> map_;
  std::int64_t changed_ = 0;                        // of the mesh
  std::int64_t version_ = -1, whole_version_ = -1;  // of the map
  int looks_ = 0;
};

}  // namespace lcmslam
