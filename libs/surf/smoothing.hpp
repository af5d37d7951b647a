#pragma once
// Low-pass before the integral image: the smallest box filters would else answer to single pixels.

#include <opencv2/core.hpp>

namespace lcmslam {

/// Side of the filter that answers most to a blob, from the side that answers most to the same blob
/// smoothed by BinomialSmoother, and back. Box filters match Gaussian blobs of side / 5.3 (measured on
/// their closed form; second derivatives of Gaussians, side / 7.5), whose variances add.
float unsmoothed_size(float size);
float smoothed_size(float size);

/// Binomial filter (1 8 28 56 70 56 28 8 1) / 256 along columns and rows: a Gaussian of sigma sqrt(2) =
/// 1.41 pixels, near the smallest blob filter's own scale. Rounds to 8 bits after both; the border is
/// the outermost pixel repeated.
class BinomialSmoother {
 public:
  /// `grey`: CV_8UC1, not empty. The answer lives until the next call. Reuses its memory; rows run in
  /// parallel, each writes its own.
  const cv::Mat& smooth(const cv::Mat& grey);

 private:
  cv::Mat smooth_;
};

}  // namespace lcmslam
