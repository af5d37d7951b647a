#pragma once
// Scores features of two images whose depth and relative pose are known, after Mikolajczyk & Schmid,
// "A Performance Evaluation of Local Descriptors", PAMI 2005, section 4: repeatability counts keypoints
// that correspond by geometry alone, precision counts which of the descriptors' matches are right. There
// a homography says what corresponds, here depth and pose; regions are compared by their centres.

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/study/feature_methods.hpp"

namespace lcmslam {

/// One image without lens distortion, and its depth.
struct StudyView {
  cv::Mat grey;   ///< CV_8UC1
  cv::Mat depth;  ///< CV_32FC1, m along the optical axis, 0 where unknown
  cv::Matx33d K;  ///< pinhole of both

  bool contains(const Eigen::Vector2d& pixel) const;
  /// Depth at the nearest pixel, m; 0 outside and where unknown.
  double depth_at(const cv::Point2f& pixel) const;
  /// Point in the camera frame, m; nothing without depth.
  std::optional<Eigen::Vector3d> point_at(const cv::Point2f& pixel) const;
};

struct EvaluationTolerances {
  double repeatability = 3;  ///< pixels between a moved keypoint and one of the other image
  double precision = 5;      ///< pixels between a moved keypoint and its match
};

/// Repeatability is the number of keypoints found again over the number that could be: those in the part
/// of the scene that both images show, with depth in both. Each number is counted from a to b and from b
/// to a, and the smaller one stands (Mikolajczyk & Schmid's "smaller of the number of regions in the
/// pair"), so that a cluster of keypoints around one of the other image counts once.
struct FeatureScore {
  int keypoints = 0;  ///< mean of the two images'
  int visible = 0;
  int repeated = 0;
  int matches = 0;  ///< with depth at both ends
  int correct = 0;  ///< of these, within the tolerance of where they belong
  double repeatability() const { return visible > 0 ? double(repeated) / visible : 0; }
  double precision() const { return matches > 0 ? double(correct) / matches : 0; }
};

/// Those with depth at their place, in the same order: a keypoint that cannot be judged shall not take
/// another's match either.
ImageFeatures with_depth(const ImageFeatures& features, const StudyView& view);

/// Pairs (row of a, row of b), in order of a: each other's nearest, and nearer to a than `ratio` times
/// b's second nearest (Lowe 2004, section 7.1). Exhaustive; of equally near ones the first counts.
std::vector<cv::Vec2i> mutual_matches(const cv::Mat& a, const cv::Mat& b, cv::NormTypes norm, double ratio);

/// Where a keypoint of a lies in b's image; nothing when it has no depth or b does not show its place.
std::optional<Eigen::Vector2d> moved_keypoint(const StudyView& a, const StudyView& b,
                                              const Eigen::Isometry3d& T_b_a, const cv::Point2f& pixel);

FeatureScore score_features(const StudyView& a, const StudyView& b, const Eigen::Isometry3d& T_b_a,
                            const ImageFeatures& in_a, const ImageFeatures& in_b,
                            const std::vector<cv::Vec2i>& matches, const EvaluationTolerances& tolerances);

/// 3-D points of a (its camera frame, m) and where b's image shows them.
struct PointsAndPixels {
  std::vector<cv::Point3f> points;
  std::vector<cv::Point2f> pixels;
};

/// Adds the matches with depth at both ends.
void add_matches(PointsAndPixels& pool, const StudyView& a, const StudyView& b, const ImageFeatures& in_a,
                 const ImageFeatures& in_b, const std::vector<cv::Vec2i>& matches);

struct ReferencePoseSettings {
  int min_inliers = 25;
  double reprojection = 3;        ///< pixels, of an inlier
  int iterations = 2000;          ///< of RANSAC, at most
  double confidence = 0.9999;     ///< of having drawn a sample without outliers
  double max_rotation = 8;        ///< degrees from the recording's pose
  double max_translation = 0.25;  ///< m from the recording's pose
};

/// T_b_a from PnP-RANSAC; nothing when it has too few inliers or is too far from the recording's.
std::optional<Eigen::Isometry3d> reference_pose(const PointsAndPixels& pool, const cv::Matx33d& K,
                                                const Eigen::Isometry3d& T_b_a_recorded,
                                                const ReferencePoseSettings& settings);

}  // namespace lcmslam
