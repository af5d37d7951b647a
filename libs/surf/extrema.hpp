#pragma once
// Blobs: maxima of the Hessian's determinant over position and scale, located between the samples.

#include <vector>

#include "surf/hessian.hpp"

namespace lcmslam {

struct Blob {
  float x = 0, y = 0;  ///< pixels
  float size = 0;      ///< side of the matching filter, the blob's diameter, pixels
  float response = 0;  ///< determinant at the interpolated maximum
  int laplacian = 0;   ///< sign of the trace: -1 bright on dark, 1 dark on bright
  int octave = 0;
};

/// Samples above `threshold` that no neighbour of their 3x3x3 surrounding exceeds (of equal neighbours
/// the first counts), moved to the maximum of the quadric through it (Brown & Lowe 2002). Maxima whose
/// quadric peaks more than one sample away are dropped. Ordered by octave, scale, row, column.
std::vector<Blob> find_blobs(const HessianPyramid& pyramid, const IntegralImage& integral, float threshold);

}  // namespace lcmslam
