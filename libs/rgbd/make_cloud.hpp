#pragma once
// The coloured cloud that a depth image and a colour image make together.

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/imaging/depth_registration.hpp>

namespace lcmslam {

/// Points with valid depth, coloured from the colour image (colourless points are left out unless
/// keep_uncoloured, then they are grey), with normals and sigmas. Takes every `step`-th row and column.
ColouredCloud make_cloud(const RgbdFrame& frame, const RegisteredDepth& registered, int step = 1,
                         bool keep_uncoloured = false);

}  // namespace lcmslam
