#pragma once
// Orientation and descriptor of a blob from Haar wavelets (Bay et al. 2008, section 4), the descriptor
// with overlapping regions (M-SURF: Agrawal, Konolige & Blas, "CenSurE", ECCV 2008, section 4).

#include <lcmslam/surf/patch.hpp>

namespace lcmslam {

/// Pixels between neighbouring points of both patches, in units of the scale s. With wider wavelets
/// (8/3 s instead of 2 s) than the paper's, fewer points describe the same window of 20 s as well.
constexpr float patch_pitch = 4.f / 3.f;

/// Dominant direction in radians, 0..2 pi, clockwise in the image: the longest sum of Haar responses
/// (wavelets of 8/3 s, within 16/3 s of the centre, weighted by a Gaussian of 2 s) over a window of
/// directions that slides by 5 degrees (paper, section 4.1). The window is no box of 60 degrees but a
/// triangle of 110 to each side: noise and rotation make no response jump in or out of it.
/// Without any gradient 0. `scale` is s in pixels.
float dominant_orientation(const PatchSampler& sampler, float x, float y, float scale);

/// Writes 64 numbers of unit norm (all 0 on a flat patch): for each of 4 x 4 regions the sums dx, dy,
/// |dx|, |dy| of Haar responses along and across `angle` (radians). A region has 6 x 6 wavelets and shares
/// half of them with each neighbour, so that a blob's small shift moves nothing abruptly to another
/// region; they are weighted by a Gaussian of 1.7 samples about the region's centre, the region by one of
/// 1.5 regions about the blob. Regions go row by row in the rotated frame.
void describe(const PatchSampler& sampler, float x, float y, float scale, float angle, float* descriptor);

/// The same with 128 numbers: each region dx and |dx| where dy >= 0, then where dy < 0, dy and |dy| where
/// dx >= 0, then where dx < 0 (paper, section 4.2, SURF-128).
void describe_extended(const PatchSampler& sampler, float x, float y, float scale, float angle,
                       float* descriptor);

}  // namespace lcmslam
