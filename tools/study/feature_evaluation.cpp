#include "tools/study/feature_evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {
namespace {

cv::Point nearest_pixel(const cv::Point2f& p) {
  return {cvRound(p.x), cvRound(p.y)};
}

struct TwoNearest {
  int first = -1;
  float distance = std::numeric_limits<float>::infinity();
  float second_distance = std::numeric_limits<float>::infinity();

  void offer(int index, float d) {
    if (d < distance) {
      second_distance = distance;
      distance = d;
      first = index;
    } else if (d < second_distance) {
      second_distance = d;
    }
  }
};

struct FoundAgain {
  int visible = 0, repeated = 0;
};

/// Keypoints of `from` that have depth and whose place `to` shows, with depth; and those of them within
/// `tolerance` of a keypoint of `to`.
FoundAgain find_again(const StudyView& from, const StudyView& to, const Eigen::Isometry3d& T_to_from,
                      const ImageFeatures& in_from, const ImageFeatures& in_to, double tolerance) {
  std::vector<Eigen::Vector2d> candidates;
  for (const cv::KeyPoint& k : in_to.keypoints)
    if (to.depth_at(k.pt) > 0) candidates.emplace_back(k.pt.x, k.pt.y);
  FoundAgain count;
  for (const cv::KeyPoint& k : in_from.keypoints) {
    const auto place = moved_keypoint(from, to, T_to_from, k.pt);
    if (!place || !(to.depth_at({static_cast<float>(place->x()), static_cast<float>(place->y())}) > 0))
      continue;
    ++count.visible;
    count.repeated += std::any_of(candidates.begin(), candidates.end(), [&](const Eigen::Vector2d& other) {
      return (other - *place).norm() <= tolerance;
    });
  }
  return count;
}

}  // namespace

bool StudyView::contains(const Eigen::Vector2d& pixel) const {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < grey.cols - 0.5 && pixel.y() < grey.rows - 0.5;
}

double StudyView::depth_at(const cv::Point2f& pixel) const {
  const cv::Point p = nearest_pixel(pixel);
  if (p.x < 0 || p.y < 0 || p.x >= depth.cols || p.y >= depth.rows) return 0;
  return static_cast<double>(depth.at<float>(p));
}

std::optional<Eigen::Vector3d> StudyView::point_at(const cv::Point2f& pixel) const {
  const double z = depth_at(pixel);
  if (!(z > 0)) return std::nullopt;
  return Eigen::Vector3d((static_cast<double>(pixel.x) - K(0, 2)) / K(0, 0) * z,
                         (static_cast<double>(pixel.y) - K(1, 2)) / K(1, 1) * z, z);
}

ImageFeatures with_depth(const ImageFeatures& features, const StudyView& view) {
  ImageFeatures kept;
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    if (!(view.depth_at(features.keypoints[i].pt) > 0)) continue;
    kept.keypoints.push_back(features.keypoints[i]);
    kept.descriptors.push_back(features.descriptors.row(static_cast<int>(i)));
  }
  return kept;
}

std::vector<cv::Vec2i> mutual_matches(const cv::Mat& a, const cv::Mat& b, cv::NormTypes norm, double ratio) {
  if (a.empty() || b.empty()) return {};
  cv::Mat distances;
  cv::batchDistance(a, b, distances, norm == cv::NORM_HAMMING ? CV_32S : CV_32F, cv::noArray(), norm);
  distances.convertTo(distances, CV_32F);
  std::vector<TwoNearest> of_a(static_cast<std::size_t>(a.rows)), of_b(static_cast<std::size_t>(b.rows));
  for (int i = 0; i < a.rows; ++i) {
    const float* row = distances.ptr<float>(i);
    for (int j = 0; j < b.rows; ++j) {
      of_a[static_cast<std::size_t>(i)].offer(j, row[j]);
      of_b[static_cast<std::size_t>(j)].offer(i, row[j]);
    }
  }
  std::vector<cv::Vec2i> matches;
  for (int i = 0; i < a.rows; ++i) {
    const TwoNearest& nearest = of_a[static_cast<std::size_t>(i)];
    if (nearest.first < 0 || of_b[static_cast<std::size_t>(nearest.first)].first != i) continue;
    if (static_cast<double>(nearest.distance) < ratio * static_cast<double>(nearest.second_distance))
      matches.emplace_back(i, nearest.first);
  }
  return matches;
}

std::optional<Eigen::Vector2d> moved_keypoint(const StudyView& a, const StudyView& b,
                                              const Eigen::Isometry3d& T_b_a, const cv::Point2f& pixel) {
  const auto point = a.point_at(pixel);
  if (!point) return std::nullopt;
  const Eigen::Vector3d p = T_b_a * *point;
  if (!(p.z() > 0)) return std::nullopt;
  const Eigen::Vector2d place(b.K(0, 0) * p.x() / p.z() + b.K(0, 2), b.K(1, 1) * p.y() / p.z() + b.K(1, 2));
  if (!b.contains(place)) return std::nullopt;
  return place;
}

FeatureScore score_features(const StudyView& a, const StudyView& b, const Eigen::Isometry3d& T_b_a,
                            const ImageFeatures& in_a, const ImageFeatures& in_b,
                            const std::vector<cv::Vec2i>& matches, const EvaluationTolerances& tolerances) {
  FeatureScore score;
  score.keypoints = static_cast<int>((in_a.keypoints.size() + in_b.keypoints.size()) / 2);
  const FoundAgain forth = find_again(a, b, T_b_a, in_a, in_b, tolerances.repeatability);
  const FoundAgain back = find_again(b, a, T_b_a.inverse(), in_b, in_a, tolerances.repeatability);
  score.visible = std::min(forth.visible, back.visible);
  score.repeated = std::min(forth.repeated, back.repeated);
  for (const cv::Vec2i& match : matches) {
    const cv::Point2f& from = in_a.keypoints[static_cast<std::size_t>(match[0])].pt;
    const cv::Point2f& to = in_b.keypoints[static_cast<std::size_t>(match[1])].pt;
    if (!(a.depth_at(from) > 0) || !(b.depth_at(to) > 0)) continue;
    ++score.matches;
    const auto place = moved_keypoint(a, b, T_b_a, from);  // outside b's image: wrong
    score.correct += place && (Eigen::Vector2d(to.x, to.y) - *place).norm() <= tolerances.precision;
  }
  return score;
}

void add_matches(PointsAndPixels& pool, const StudyView& a, const StudyView& b, const ImageFeatures& in_a,
                 const ImageFeatures& in_b, const std::vector<cv::Vec2i>& matches) {
  for (const cv::Vec2i& match : matches) {
    const auto point = a.point_at(in_a.keypoints[static_cast<std::size_t>(match[0])].pt);
    const cv::Point2f& pixel = in_b.keypoints[static_cast<std::size_t>(match[1])].pt;
    if (!point || !(b.depth_at(pixel) > 0)) continue;
    pool.points.emplace_back(static_cast<float>(point->x()), static_cast<float>(point->y()),
                             static_cast<float>(point->z()));
    pool.pixels.push_back(pixel);
  }
}

std::optional<Eigen::Isometry3d> reference_pose(const PointsAndPixels& pool, const cv::Matx33d& K,
                                                const Eigen::Isometry3d& T_b_a_recorded,
                                                const ReferencePoseSettings& settings) {
  if (static_cast<int>(pool.points.size()) < settings.min_inliers) return std::nullopt;
  cv::Mat rotation_vector, translation_vector;
  std::vector<int> inliers;
  cv::setRNGSeed(1);  // the same samples on every run
  if (!cv::solvePnPRansac(pool.points, pool.pixels, K, cv::noArray(), rotation_vector, translation_vector,
                          false, settings.iterations, static_cast<float>(settings.reprojection),
                          settings.confidence, inliers, cv::SOLVEPNP_EPNP) ||
      static_cast<int>(inliers.size()) < settings.min_inliers)
    return std::nullopt;
  // RANSAC's answer is a linear one: least squares of its inliers' reprojections is what judges.
  PointsAndPixels agreeing;
  for (const int i : inliers) {
    agreeing.points.push_back(pool.points[static_cast<std::size_t>(i)]);
    agreeing.pixels.push_back(pool.pixels[static_cast<std::size_t>(i)]);
  }
  cv::solvePnPRefineLM(agreeing.points, agreeing.pixels, K, cv::noArray(), rotation_vector,
                       translation_vector);

  const auto vector_of = [](const cv::Mat& v) {
    return Eigen::Vector3d(v.at<double>(0), v.at<double>(1), v.at<double>(2));
  };
  Eigen::Isometry3d T_b_a = Eigen::Isometry3d::Identity();
  T_b_a.linear() = so3_exp(vector_of(rotation_vector));
  T_b_a.translation() = vector_of(translation_vector);
  const Eigen::Isometry3d difference = T_b_a_recorded.inverse() * T_b_a;
  if (!(rotation_angle(difference) * 180 / CV_PI <= settings.max_rotation) ||
      !(difference.translation().norm() <= settings.max_translation))
    return std::nullopt;
  return T_b_a;
}

}  // namespace lcmslam
