#pragma once
// Orientation and 64-D descriptor of a blob from Haar wavelets (Bay et al. 2008, section 4).

#include "surf/patch.hpp"

namespace lcmslam {

/// Dominant direction in radians, 0..2 pi, clockwise in the image: the longest sum of Haar responses
/// (wavelets of side 4 s, within 6 s of the centre, weighted by a Gaussian of 2 s) over a window of 60
/// degrees that slides by 5 (section 4.1). Without any gradient 0. `scale` is s in pixels.
float dominant_orientation(const PatchSampler& sampler, float x, float y, float scale);

/// Writes 64 numbers of unit norm (all 0 on a flat patch): for each of 4 x 4 regions of 5 s the sums
/// dx, dy, |dx|, |dy| of Haar responses along and across `angle` (radians), wavelets of side 2 s,
/// weighted by a Gaussian of 3.3 s (section 4.2). Regions go row by row in the rotated frame.
void describe(const PatchSampler& sampler, float x, float y, float scale, float angle, float* descriptor);

}  // namespace lcmslam
