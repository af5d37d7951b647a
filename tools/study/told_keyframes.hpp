#pragma once
// Where a mapper's graph has the keyframes of its first map at the end, and how wrong that may be by what it
// says.

#include <map>
#include <string>

#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/messages/followed_graph.hpp>

namespace lcmslam {

/// From ICP_GRAPH, ICP_GRAPH_COVARIANCE and ICP_KEYFRAME, as they come.
class ToldKeyframes {
 public:
  /// Messages of other channels, and of later maps, are left alone.
  void hear(const std::string& channel, const std::vector<std::uint8_t>& bytes);

  /// The robot's poses at the keyframes, which are those of the cameras and where they sit on it. Nodes that
  /// only keep the path's place are none. Sorted.
  Trajectory path() const;

 private:
  FollowedGraph graph_;
  std::map<std::int32_t, Matrix6d> covariances_;      // of T_map_camera
  std::map<std::int32_t, Eigen::Isometry3d> mounts_;  // T_robot_camera
};

}  // namespace lcmslam
