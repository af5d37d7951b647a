#pragma once
// A map on the board: clouds, graph, landmarks and paths, each time as far as they have changed.

#include <limits>
#include <map>
#include <string>
#include <vector>

#include <lcmslam/live_page/map_items.hpp>
#include <lcmslam/web/board.hpp>

namespace lcmslam {

class ShownMap {
 public:
  explicit ShownMap(Board& board) : board_(board) {}

  /// Clouds stay in their camera's frame: when the graph bends, graph() alone moves them. So many points at
  /// most, or one cloud, the newest keyframes first; returns whether all are shown now.
  bool clouds(const DenseMap& map, std::size_t most_points = std::numeric_limits<std::size_t>::max());
  void graph(const std::vector<KeyframePose>& nodes, const std::vector<PageEdge>& edges);
  void landmarks(std::vector<Landmark> landmarks);
  /// By name: "icp", "fastslam", "odometry", "truth"; of each so many lines, with nothing between them. Null:
  /// there is none.
  using Path = std::vector<Eigen::Vector3d>;
  void paths(const std::map<std::string, std::vector<const Path*>>& paths);

  /// Another map begins.
  void forget();

 private:
  void forget_gone(const DenseMap& map);

  Board& board_;
  std::map<std::int32_t, std::int64_t> clouds_;  // revision of the cloud that is shown, by keyframe
};

}  // namespace lcmslam
