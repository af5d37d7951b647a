#pragma once
// Square patches of the image at any place, angle and pitch: the one kind of input from which both the
// orientation and the descriptor take their Haar wavelets.

#include <cstddef>
#include <vector>

#include "surf/integral.hpp"

namespace lcmslam {

/// Where a patch lies: point (i, j) of an n x n patch is the mean grey value of an upright box of side
/// round(pitch) centred on (x, y) + pitch * R(angle) * (i - (n-1)/2, j - (n-1)/2).
struct PatchPose {
  float x = 0, y = 0;          ///< centre, pixels
  float cosine = 1, sine = 0;  ///< of the angle, clockwise in the image
  float pitch = 1;             ///< pixels between neighbours
};

/// Samples patches. Small boxes come from box-filtered copies of the image, made once and interpolated
/// between pixels; large ones directly from the integral image at the nearest pixel, where half a pixel
/// matters little. Outside the image the border's values continue.
class PatchSampler {
 public:
  /// Boxes up to this side are filtered beforehand.
  static constexpr int max_filtered_side = 5;

  /// `pitches`: the patches that will be asked for. Keeps a pointer to `integral`.
  void prepare(const IntegralImage& integral, const std::vector<float>& pitches);

  /// Writes n * n means (0..255), row by row; safe from several threads at once. The pitch must be one
  /// of those prepared.
  void sample(const PatchPose& pose, int n, float* patch) const;

 private:
  void filter(int side);
  void sample_filtered(const PatchPose& pose, int n, int side, float* patch) const;
  void sample_boxes(const PatchPose& pose, int n, int side, float* patch) const;

  const IntegralImage* integral_ = nullptr;
  std::vector<float> filtered_[max_filtered_side + 1];  // by side
};

}  // namespace lcmslam
