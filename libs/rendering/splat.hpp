#pragma once
// Draws coloured points as overlapping discs with hidden surfaces removed: a software version of
// surface splatting (Zwicker et al. 2001) with round kernels, and eye-dome lighting (Boucheny 2009)
// for relief.

#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/rendering/view_camera.hpp>

namespace lcmslam {

struct SplatPoint {
  Eigen::Vector3d position;  ///< m, world
  cv::Vec3b colour;          ///< BGR
  float spacing;             ///< m, to the neighbouring points of its surface
  bool paint = false;        ///< gives its colour to what other points show there, and is nothing itself
};

/// Draws over `picture` (CV_8UC3). Where dense points and sparse ones lie on the same surface, the dense ones
/// count.
void draw_splats(cv::Mat& picture, const ViewCamera& camera, const std::vector<SplatPoint>& points);

}  // namespace lcmslam
