#pragma once
// A map on the board: clouds, graph, landmarks and paths, each time as far as they have changed.

#include <map>
#include <string>
#include <vector>

#include <lcmslam/live_page/map_items.hpp>
#include <lcmslam/web/board.hpp>

namespace lcmslam {

class ShownMap {
 public:
  explicit ShownMap(Board& board) : board_(board) {}

  /// Clouds stay in their camera's frame: when the graph bends, graph() alone moves them.
  void clouds(const DenseMap& map);
  void graph(const std::vector<KeyframePose>& nodes, const std::vector<PageEdge>& edges);
  void landmarks(std::vector<Landmark> landmarks);
  /// By name: "icp", "fastslam", "odometry", "truth". Null: there is none.
  using Path = std::vector<Eigen::Vector3d>;
  void paths(const std::map<std::string, const Path*>& paths);

  /// Another map begins.
  void forget();

 private:
  Board& board_;
  std::map<std::int32_t, std::int64_t> clouds_;  // revision of the cloud that is shown, by keyframe
};

}  // namespace lcmslam
