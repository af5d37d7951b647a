#pragma once
// Where the planes of a depth image end, pixel by pixel.

#include <lcmslam/planes/cell_moments.hpp>
#include <lcmslam/planes/frame_planes.hpp>

namespace lcmslam {

/// Labels the pixels, and fits the planes to what is theirs alone. Cells amid a plane are its own as they
/// are. Of cells at a rim and of those around it each pixel goes to the plane nearby that it lies in: what of
/// such cells is another thing's would tilt small planes. `moments` and `plane_of_cell` (number of the plane
/// from 1 on, 0: none) are of the cells of `depth`.
void follow_rims(const cv::Mat& depth, const CellMoments& cells, const std::vector<PlaneMoments>& moments,
                 const std::vector<std::uint8_t>& plane_of_cell, const FramePlaneSettings& settings,
                 FramePlanes& found);

}  // namespace lcmslam
