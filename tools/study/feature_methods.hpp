#pragma once
// The detectors and descriptors that the feature study compares, each behind one interface.

#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace lcmslam {

/// What one method finds in one image, strongest response first.
struct ImageFeatures {
  std::vector<cv::KeyPoint> keypoints;  ///< pixels of the image that was given
  cv::Mat descriptors;                  ///< one row a keypoint
};

/// At most the first `count` of them.
ImageFeatures first_features(const ImageFeatures& features, std::size_t count);

/// Orders by response, equal ones by place, so that "the strongest" are the same on every run.
ImageFeatures strongest_first(const ImageFeatures& features);

class FeatureMethod {
 public:
  virtual ~FeatureMethod() = default;
  /// In tables: "cv::ORB".
  virtual std::string name() const = 0;
  /// Methods of one family see the same things: none of them has a say about another's pairs.
  virtual std::string family() const = 0;
  virtual cv::NormTypes norm() const = 0;  ///< between descriptors
  /// Detects and describes in an 8-bit grey image; the order does not matter.
  virtual ImageFeatures compute(const cv::Mat& grey) = 0;
};

using FeatureMethods = std::vector<std::unique_ptr<FeatureMethod>>;

/// Each is asked for at most `count` keypoints, the strongest wherever they lie.
std::unique_ptr<FeatureMethod> lcmslam_surf_method(int count, bool extended = false);
std::unique_ptr<FeatureMethod> sift_method(int count);
std::unique_ptr<FeatureMethod> orb_method(int count);
/// Gives fewer than asked: dlib drops keypoints near the border after it has counted them. Nothing when
/// dlib's headers (libdlib-dev) were absent at build time.
std::unique_ptr<FeatureMethod> dlib_surf_method(int count);

/// All of them, ours first.
FeatureMethods all_feature_methods(int count);

}  // namespace lcmslam
