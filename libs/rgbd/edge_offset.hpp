#pragma once
// Whether depth edges lie on colour edges: of all scales and shifts around the one that the calibration says,
// the one at which most colour gradient lies under the edges of depth. Not every edge of depth is one of
// colour; over some frames the true place wins.

#include <vector>

#include <lcmslam/imaging/depth_registration.hpp>

namespace lcmslam {

class EdgeOffset {
 public:
  EdgeOffset();
  /// `depth`: with pixels, or aligned.
  void add(const RgbdFrame& frame, const RegisteredDepth& depth);

  struct Best {
    double scale = 1;  ///< depth's pixels must be moved away from the image's middle by this factor,
    double right = 0, down = 0;  ///< and then by so many pixels of the colour image
    double gain = 1;      ///< gradient there by that at the calibration's place, above the image's mean
    double contrast = 0;  ///< gradient there by the image's mean
  };
  /// Of all frames so far.
  Best best() const;
  std::size_t edge_points() const { return points_; }

 private:
  std::vector<double> sums_;  // of the gradient under all edge points, by scale and shift
  double mean_ = 0;           // the same for points anywhere
  std::size_t points_ = 0;
  double pixel_ = 1;  // colour pixels by a pixel of the small image that is looked at
};

}  // namespace lcmslam
