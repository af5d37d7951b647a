#pragma once
// Viewpoints on a circle around a map, for a picture that moves.

#include <vector>

#include <lcmslam/rendering/map_picture.hpp>

namespace lcmslam {

/// `count` viewpoints T_world_viewer (x right, y down, z forward), one turn to the left in even steps, all of
/// them as far from the map's middle as the whole of it needs to be seen. The first one looks as the front
/// view does. `request`: size, field of view, and the map; one point far away moves nothing.
std::vector<Eigen::Isometry3d> orbit(const PictureRequest& request, int count);

}  // namespace lcmslam
