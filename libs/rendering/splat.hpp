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
};

/// Draws over `picture` (CV_8UC3). `spacing` in m between neighbouring points of a surface.
void draw_splats(cv::Mat& picture, const ViewCamera& camera, const std::vector<SplatPoint>& points,
                 double spacing);

}  // namespace lcmslam
