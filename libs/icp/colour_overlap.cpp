#include "icp/colour_overlap.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

namespace lcmslam {
namespace {

void check(const cv::Mat& source, const cv::Mat& target, const ColourOverlapSettings& s) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("colour overlap: ") + what);
  };
  require(source.type() == CV_8UC1 || source.type() == CV_8UC3, "images must be 8-bit with 1 or 3 channels");
  require(!source.empty() && source.size() == target.size() && source.type() == target.type(),
          "both images must be of one size and type");
  require(s.columns >= 1 && s.rows >= 1, "columns and rows must be positive");
  require(s.scale > 0 && s.scale <= 1, "scale must be in (0, 1]");
  require(s.threshold >= -1 && s.threshold <= 1, "threshold must be in [-1, 1]");
  require(s.search >= 0 && s.min_contrast >= 0, "search and min_contrast must not be negative");
}

cv::Mat reduced_grey(const cv::Mat& image, double scale) {
  cv::Mat grey = image, small;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  if (scale == 1) return grey;
  cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
  return small;
}

double contrast(const cv::Mat& grey) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(grey, mean, deviation);
  return deviation[0];
}

// Segment (column, row) of a grid over an image; all pixels belong to one.
cv::Rect segment_area(int column, int row, const ColourOverlapSettings& s, const cv::Size& size) {
  const int left = column * size.width / s.columns, right = (column + 1) * size.width / s.columns;
  const int top = row * size.height / s.rows, bottom = (row + 1) * size.height / s.rows;
  return {left, top, right - left, bottom - top};
}

}  // namespace

ColourOverlap::ColourOverlap(const cv::Mat& source, const cv::Mat& target,
                             const ColourOverlapSettings& settings, const cv::Point2d& shift)
    : settings_(settings), size_(source.size()) {
  check(source, target, settings);
  const cv::Mat small_source = reduced_grey(source, settings.scale);
  const cv::Mat small_target = reduced_grey(target, settings.scale);
  const double scale = static_cast<double>(small_source.cols) / source.cols;
  const cv::Rect whole({0, 0}, small_target.size());
  for (int row = 0; row < settings.rows; ++row)
    for (int column = 0; column < settings.columns; ++column) {
      Segment segment;
      segment.area = segment_area(column, row, settings, size_);
      const cv::Rect small = segment_area(column, row, settings, small_source.size());
      cv::Rect searched = whole;
      if (settings.search > 0) {
        const int reach = static_cast<int>(std::ceil(scale * settings.search));
        const cv::Point corner(cvRound(small.x + scale * shift.x) - reach,
                               cvRound(small.y + scale * shift.y) - reach);
        searched &= cv::Rect(corner, small.size() + cv::Size(2 * reach, 2 * reach));
      }
      segments_.push_back(segment);
      if (small.empty()) continue;
      const cv::Mat sought = small_source(small);
      if (!(contrast(sought) > settings.min_contrast)) continue;
      segments_.back().state = SegmentState::outside;
      if (searched.width < small.width || searched.height < small.height) continue;
      cv::Mat coefficients;
      cv::matchTemplate(small_target(searched), sought, coefficients, cv::TM_CCOEFF_NORMED);
      cv::Point best;
      double coefficient = 0;
      cv::minMaxLoc(coefficients, nullptr, &coefficient, nullptr, &best);
      Segment& found = segments_.back();
      found.coefficient = std::isfinite(coefficient) ? coefficient : 0;
      found.found =
          cv::Point2d(searched.x + best.x + 0.5 * small.width, searched.y + best.y + 0.5 * small.height) /
          scale;
      if (found.coefficient >= settings.threshold) found.state = SegmentState::overlapping;
    }
}

const Segment* ColourOverlap::at(double x, double y) const {
  if (!(x >= 0 && y >= 0 && x < size_.width && y < size_.height)) return nullptr;
  const cv::Point pixel(static_cast<int>(x), static_cast<int>(y));
  for (const Segment& segment : segments_)
    if (segment.area.contains(pixel)) return &segment;
  return nullptr;
}

std::optional<double> ColourOverlap::overlap() const {
  int known = 0, overlapping = 0;
  for (const Segment& segment : segments_) {
    known += segment.state != SegmentState::unknown ? 1 : 0;
    overlapping += segment.state == SegmentState::overlapping ? 1 : 0;
  }
  if (known == 0) return std::nullopt;
  return static_cast<double>(overlapping) / known;
}

bool may_overlap(const Eigen::Vector3d& point, const ColourOverlap& overlap, const CameraModel& camera) {
  const auto pixel = camera.project(point);
  const Segment* segment = pixel ? overlap.at(pixel->x() + 0.5, pixel->y() + 0.5) : nullptr;
  return segment != nullptr && segment->state != SegmentState::outside;
}

Cloud overlapping_points(const Cloud& cloud, const ColourOverlap& overlap, const CameraModel& camera,
                         const Eigen::Isometry3d& T_camera_cloud) {
  return kept_points(cloud, [&](std::size_t i) {
    return may_overlap(T_camera_cloud * cloud.points[i].cast<double>(), overlap, camera);
  });
}

}  // namespace lcmslam
