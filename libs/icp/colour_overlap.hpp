#pragma once
// Which part of a source image the target image shows too, from colour alone (thesis section 3.4.1, steps 1
// of algorithm 3.2): the source is cut into segments, each is looked for in the target by the normalised
// correlation coefficient (eq. 3.3; cv::TM_CCOEFF_NORMED).

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "icp/cloud.hpp"
#include "imaging/camera_model.hpp"

namespace lcmslam {

struct ColourOverlapSettings {
  int columns = 8, rows = 6;  ///< segments
  double scale = 0.25;        ///< of both images, in which is searched: at full size it takes seconds
  double threshold = 0.7;     ///< coefficient from which on a segment is found again
  double min_contrast = 4;    ///< standard deviation in grey values; plainer segments have no coefficient
  double search = 0;          ///< pixels (full size) around the expected place; 0: everywhere
};

enum class SegmentState { outside, overlapping, unknown };

struct Segment {
  cv::Rect area;  ///< source image, pixels
  SegmentState state = SegmentState::unknown;
  double coefficient = 0;  ///< best one, -1..1; 0 when unknown
  cv::Point2d found;       ///< centre of the best place, target image, pixels
};

class ColourOverlap {
 public:
  /// `source` and `target`: CV_8UC1 or CV_8UC3 of one size. Segments are expected where `shift` (pixels)
  /// moves them, when only around there is searched. Throws std::invalid_argument for images that do not fit
  /// together and settings out of range.
  ColourOverlap(const cv::Mat& source, const cv::Mat& target, const ColourOverlapSettings& settings = {},
                const cv::Point2d& shift = {});

  const std::vector<Segment>& segments() const { return segments_; }  ///< row by row
  /// The segment of a source pixel; none outside the image.
  const Segment* at(double x, double y) const;
  /// Share of the segments whose state is known that overlap; nothing when none is known.
  std::optional<double> overlap() const;

 private:
  ColourOverlapSettings settings_;
  cv::Size size_;
  std::vector<Segment> segments_;
};

/// Whether a point of the source's colour camera frame projects into an overlapping segment, or an unknown
/// one, which may overlap.
bool may_overlap(const Eigen::Vector3d& point, const ColourOverlap& overlap, const CameraModel& camera);

/// S_sub: the points that may overlap.
Cloud overlapping_points(const Cloud& cloud, const ColourOverlap& overlap, const CameraModel& camera,
                         const Eigen::Isometry3d& T_camera_cloud = Eigen::Isometry3d::Identity());

}  // namespace lcmslam
