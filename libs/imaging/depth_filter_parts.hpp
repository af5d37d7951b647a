#pragma once
// The parts of the depth filter, one file each.

#include <lcmslam/imaging/depth_filter.hpp>

namespace lcmslam {

std::unique_ptr<DepthFilterPart> make_amplitude_filter(const AmplitudeFilterSettings& settings);
std::unique_ptr<DepthFilterPart> make_jump_edge_filter(const JumpEdgeFilterSettings& settings);
std::unique_ptr<DepthFilterPart> make_speckle_filter(const SpeckleFilterSettings& settings);
std::unique_ptr<DepthFilterPart> make_bilateral_filter(const BilateralFilterSettings& settings);

}  // namespace lcmslam
