#pragma once
// Which part of the source's image the target's image shows too, as rejection asks for it. (How it is found:
// rgbd/colour_overlap.hpp.)

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/imaging/camera_model.hpp>

namespace lcmslam {

enum class SegmentState { outside, overlapping, unknown };

struct Segment {
  cv::Rect area;  ///< source image, pixels
  SegmentState state = SegmentState::unknown;
  double coefficient = 0;  ///< of correlation at the best place, -1..1; 0 when unknown
  cv::Point2d found;       ///< centre of the best place, target image, pixels
};

class ImageOverlap {
 public:
  /// Segments of a source image of this size, row by row.
  ImageOverlap(const cv::Size& size, std::vector<Segment> segments)
      : size_(size), segments_(std::move(segments)) {}

  const std::vector<Segment>& segments() const { return segments_; }
  /// The segment of a source pixel; none outside the image.
  const Segment* at(double x, double y) const;
  /// Share of the segments whose state is known that overlap; nothing when none is known.
  std::optional<double> overlap() const;

 private:
  cv::Size size_;
  std::vector<Segment> segments_;
};

/// Whether a point of the source's colour camera frame projects into an overlapping segment, or an unknown
/// one, which may overlap.
bool may_overlap(const Eigen::Vector3d& point, const ImageOverlap& overlap, const CameraModel& camera);

/// S_sub: the points that may overlap.
Cloud overlapping_points(const Cloud& cloud, const ImageOverlap& overlap, const CameraModel& camera,
                         const Eigen::Isometry3d& T_camera_cloud = Eigen::Isometry3d::Identity());

}  // namespace lcmslam
