#pragma once
// Determinant of the Hessian over position and scale from box filters (Bay, Ess, Tuytelaars & Van
// Gool, "Speeded-Up Robust Features", CVIU 2008, section 3).

#include <cstddef>
#include <vector>

#include <lcmslam/surf/integral.hpp>

namespace lcmslam {

/// Sums of the three box filters at one pixel, not normalised.
struct BoxHessian {
  int xx = 0, yy = 0, xy = 0;
};

/// Filter of side 3 * lobe (lobe odd, at least 3) centred on pixel (x, y); it must lie in the image.
BoxHessian box_hessian(const IntegralImage& integral, int lobe, int x, int y);

/// w^2, the weight of Dxy^2 in the determinant: it makes up for the boxes' Frobenius norms (paper, eq.
/// 4); 0.913^2 for side 9.
inline float determinant_weight2(int lobe) {
  return static_cast<float>(2 * lobe - 1) / static_cast<float>(2 * lobe);
}

/// Blob scale (sigma of the matching Gaussian, pixels) of a filter of that side (paper, section 3.3).
inline float scale_of_filter(float side) {
  return side * (1.2f / 9.f);
}

/// Responses of one filter on the pixels (column * step, row * step).
struct HessianLayer {
  int lobe = 0;  ///< third of the filter's side, pixels
  int step = 1;  ///< pixels between two samples
  int columns = 0, rows = 0;
  int first_column = 0, last_column = -1;  ///< samples where the filter lies in the image,
  int first_row = 0, last_row = -1;        ///< inclusive; the others are undefined
  std::vector<float> determinants;

  const float* row(int r) const {
    return determinants.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(columns);
  }
  float* row(int r) {
    return determinants.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(columns);
  }
};

/// Octave o (0, 1, ...) holds `intervals` filters of lobes 2^(o+1) i + 1, i = 1..intervals (sides 9,
/// 15, 21, 27; 15, 27, 39, 51; ...). They are sampled every 2^(o-1) pixels, octave 0 at each: twice as
/// densely as in the paper, which finds blobs again more often (README, feature study).
///
/// The determinant is (Dxx Dyy - w^2 Dxy^2) / (lobe (2 lobe - 1))^2: each second derivative is a
/// difference of mean grey values (0..255), so that thresholds mean the same at all scales. w makes up
/// for the boxes' Frobenius norms (paper, eq. 4): w^2 = (2 lobe - 1) / (2 lobe), 0.913 for side 9.
class HessianPyramid {
 public:
  /// Reuses its memory from call to call. Rows run in parallel (cv::parallel_for_), each writes its own.
  void compute(const IntegralImage& integral, int octaves, int intervals);

  int octaves() const { return octaves_; }
  int intervals() const { return intervals_; }
  const HessianLayer& layer(int octave, int interval) const { return layers_[slot(octave, interval)]; }

 private:
  std::size_t slot(int octave, int interval) const {
    return slots_[static_cast<std::size_t>(octave * intervals_ + interval)];
  }

  int octaves_ = 0, intervals_ = 0;
  std::vector<HessianLayer> layers_;
  std::vector<std::size_t> slots_;  ///< of the octaves' filters; octaves 0 and 1 share some
};

}  // namespace lcmslam
