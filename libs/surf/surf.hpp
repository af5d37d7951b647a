#pragma once
// SURF, the Speeded-Up Robust Features of Bay et al. (CVIU 2008), as an OpenCV Feature2D.

#include <opencv2/features2d.hpp>
#include <vector>

#include <lcmslam/settings/settings.hpp>
#include <lcmslam/surf/extrema.hpp>
#include <lcmslam/surf/feature_budget.hpp>
#include <lcmslam/surf/hessian.hpp>
#include <lcmslam/surf/patch.hpp>
#include <lcmslam/surf/smoothing.hpp>

namespace lcmslam {

struct SurfSettings {
  double hessian_threshold = 100;
  int octaves = 4;
  int intervals = 4;
  /// The paper does not smooth. Thresholds speak of the smoothed image; keypoints' sizes of the given one.
  bool smooth = true;
  /// Along a line a blob stands where the line is as wide as its filter, which moves with the camera: what is
  /// longer than this slides along as a robot goes by.
  double edge_ratio = 3;
  /// 128-D descriptors, the sums split by the other derivative's sign. No key: a message holds 64.
  bool extended = false;
  bool upright = false;
  FeatureBudget budget;

  void describe(SettingsVisitor& s) {
    s.number("hessian_threshold", hessian_threshold, "grey values^2", {0, 1e6},
             "least determinant of the Hessian, of box means of grey values from 0 to 255");
    s.number("octaves", octaves, "", {1, 6}, "of filter sides: 9 to 27, 15 to 51, 27 to 99, 51 to 195, ...");
    s.number("intervals", intervals, "", {3, 8},
             "filters an octave; blobs are found at all but the first and the last");
    s.flag("smooth", smooth,
           "smooths the image first (sigma 1.41 pixels): more blobs are found again and matched");
    s.number("edge_ratio", edge_ratio, "", {1, 1e6},
             "of the second derivatives across and along, beyond which a blob is an edge");
    s.flag("upright", upright, "no orientation: faster, more distinctive while the camera is level");
    budget.describe(s);
  }
};

/// Detector and descriptor. Keypoints: pt in pixels, size = the blob's diameter (side of the matching
/// filter; sigma = 1.2 size / 9), angle in degrees clockwise (0..360), response = determinant, octave
/// 0.., class_id = sign of the Laplacian (-1 bright blob, 1 dark blob), strongest first. Descriptors:
/// CV_32F, one row of 64 (extended: 128) a keypoint, unit norm.
///
/// Images are 8-bit with 1, 3 (BGR) or 4 (BGRA) channels; masks CV_8UC1 of the same size, 0 where no
/// keypoint may be. Anything else throws std::invalid_argument. Empty or tiny images have no keypoints.
///
/// Bit-identical whatever cv::setNumThreads says. Keeps its buffers between calls: use one instance a
/// thread. Once the buffers have grown to a kind of image, a call takes no memory from the heap but for
/// the caller's keypoints and descriptors.
class Surf : public cv::Feature2D {
 public:
  /// Throws std::invalid_argument when a setting is out of its range.
  explicit Surf(const SurfSettings& settings = {});
  static cv::Ptr<Surf> create(const SurfSettings& settings = {}) { return cv::makePtr<Surf>(settings); }

  const SurfSettings& settings() const { return settings_; }
  /// For the images that follow. Throws std::invalid_argument when it is out of its range.
  void set_hessian_threshold(double threshold);
  /// Blobs above the threshold in the last image, before the budget chose from them.
  int blobs_found() const { return blobs_found_; }

  /// With use_provided_keypoints nothing is detected; keypoints with a negative angle (unset) get their
  /// orientation, others keep theirs (upright: 0). `descriptors` may be cv::noArray().
  void detectAndCompute(cv::InputArray image, cv::InputArray mask, std::vector<cv::KeyPoint>& keypoints,
                        cv::OutputArray descriptors, bool use_provided_keypoints = false) override;

  int descriptorSize() const override { return settings_.extended ? 128 : 64; }
  int descriptorType() const override { return CV_32F; }
  int defaultNorm() const override { return cv::NORM_L2; }
  bool empty() const override { return false; }
  cv::String getDefaultName() const override { return "lcmslam.Surf"; }

 private:
  void detect_blobs(const cv::Mat& mask, std::vector<cv::KeyPoint>& keypoints);

  SurfSettings settings_;
  int blobs_found_ = 0;
  cv::Mat grey_;
  BinomialSmoother smoother_;
  IntegralImage integral_;
  HessianPyramid pyramid_;
  BlobFinder finder_;
  BlobSelection selection_;
  std::vector<Blob> blobs_;
  std::vector<float> scales_, pitches_;  ///< of the keypoints, pixels
  PatchSampler sampler_;
};

}  // namespace lcmslam
