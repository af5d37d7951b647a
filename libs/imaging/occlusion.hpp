#pragma once
// Which depth points the colour camera cannot see because nearer ones stand in front of them.

#include <lcmslam/imaging/depth_registration.hpp>

namespace lcmslam {

/// Sets the pixel of every hidden point to NaN. Each point covers a square of registered.footprint
/// colour pixels, so that a coarse depth image closes a fine colour image without holes; a point is
/// hidden when something covers it that is nearer by more than the surface's slope and noise explain.
/// Where pixels are known at every `step`-th row and column alone, points cover that much more.
void hide_occluded(RegisteredDepth& registered, cv::Size colour_size, int step = 1);

}  // namespace lcmslam
