#pragma once
// Blobs: maxima of the Hessian's determinant over position and scale, located between the samples.

#include <vector>

#include <lcmslam/surf/hessian.hpp>

namespace lcmslam {

struct Blob {
  float x = 0, y = 0;  ///< pixels
  float size = 0;      ///< side of the matching filter, the blob's diameter, pixels
  float response = 0;  ///< determinant at the interpolated maximum
  int laplacian = 0;   ///< sign of the trace: -1 bright on dark, 1 dark on bright
  int octave = 0;
};

/// Samples above `threshold` that no neighbour of their 3x3x3 surrounding exceeds (of equal neighbours
/// the first counts), moved to the maximum of the quadric through it (Brown & Lowe 2002). Dropped are
/// maxima whose quadric peaks more than one sample away, and those on edges, which slide along them: where
/// the second derivative across is more than `edge_ratio` (1 or more) times that along (Lowe 2004,
/// section 4.1). Ordered by octave, scale, row, column, whatever the number of threads.
class BlobFinder {
 public:
  /// Replaces `blobs`. Reuses its memory from call to call.
  void find(const HessianPyramid& pyramid, const IntegralImage& integral, float threshold, float edge_ratio,
            std::vector<Blob>& blobs);

 private:
  /// Some rows of one layer, and what is found there.
  struct Band {
    int octave = 0, layer = 0;
    int first_row = 0, end_row = 0;
    std::vector<Blob> blobs;
  };

  std::vector<Band> bands_;
};

}  // namespace lcmslam
