#pragma once
// The parts of the depth filter, one file each.

#include "imaging/depth_filter.hpp"
#include "imaging/row_kernel.hpp"

namespace lcmslam {

std::unique_ptr<DepthFilterPart> make_amplitude_filter(const AmplitudeFilterSettings& settings);
std::unique_ptr<DepthFilterPart> make_jump_edge_filter(const JumpEdgeFilterSettings& settings);
std::unique_ptr<DepthFilterPart> make_speckle_filter(const SpeckleFilterSettings& settings);
std::unique_ptr<DepthFilterPart> make_bilateral_filter(const BilateralFilterSettings& settings);

}  // namespace lcmslam
