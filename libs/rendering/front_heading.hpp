#pragma once
// Which way the front view looks.

#include <vector>

#include <lcmslam/rendering/map_picture.hpp>

namespace lcmslam {

/// Unit vector in the plane. Along the long side of the room, from the side where the robot started
/// (in a square room, or from the middle, towards world x: as the robot looked at first). A map whose
/// surfaces nearly all face one way, such as one kitchen front, is looked at from there instead.
/// `points`: a sample of the map, for its extent.
Eigen::Vector2d front_heading(const PictureRequest& request, const std::vector<Eigen::Vector3d>& points);

}  // namespace lcmslam
