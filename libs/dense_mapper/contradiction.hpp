#pragma once
// What a frame says for and against the map at the place where the robot is thought to be, however much of it
// fits: what it looks through is not there, what stands where it stood is.

#include <optional>
#include <vector>

#include <lcmslam/rgbd/dense_frame.hpp>

namespace lcmslam {

class VoxelMap;

/// Share of the map's surfaces in the view that the frame looks through; 0 where it shows few of them. A
/// place that is some centimetres off looks through edges and floors as well, so tolerance is wide.
double seen_through(const DenseFrame& frame, const Eigen::Isometry3d& T_world_camera, const VoxelMap& map);

/// Whether the frame shows little but things that stand close before what the map has in its view: it says
/// nothing of where the robot is. Who looks through some of the map does not only stand behind something.
bool hides_the_map(const DenseFrame& frame, const Eigen::Isometry3d& T_world_camera, const VoxelMap& map);

/// Whether most of what the map has in the frame's view is seen where it is, and is no close thing, which may
/// have moved by itself. True where hardly anything near is mapped.
bool shows_the_map(const DenseFrame& frame, const Eigen::Isometry3d& T_world_camera, const VoxelMap& map);

/// Of a cloud whose points lie elsewhere as seen from two places: points that tell for the first and for the
/// second, by how much nearer to the map they lie.
struct Standing {
  double stands = 0, moved = 0;  ///< points
  std::vector<bool> has_moved;   ///< of each point
};
Standing compare(const Cloud& cloud, const Eigen::Isometry3d& T_stood, const Eigen::Isometry3d& T_led,
                 const VoxelMap& map);

/// Of a robot that stood at `T_stood`, say its wheels, and whose cloud (robot frame) registration led to
/// `T_led`: the cloud without what lies on the map from there, where that is something that moves. Then it is
/// one thing, or a good part of what the two places tell apart lies on the map from where the robot stood.
/// Nothing where the robot itself has moved: all of the map does then.
std::optional<Cloud> what_stands(const Cloud& cloud, const Eigen::Isometry3d& T_stood,
                                 const Eigen::Isometry3d& T_led, const VoxelMap& map);

/// Whether some of the walls that a cloud (robot frame) shows stand where the map has them, to a few
/// centimetres: where a door opens or somebody steps in, the rest does. The floor says nothing: it is
/// everywhere. `T_fitted`: where registration led the robot, from `T_predicted`.
bool still_shows(const Cloud& cloud, const Eigen::Isometry3d& T_predicted, const Eigen::Isometry3d& T_fitted,
                 const VoxelMap& map);

}  // namespace lcmslam
