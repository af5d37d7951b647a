#include <lcmslam/rgbd/colour_overlap.hpp>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

void check(const cv::Mat& source, const cv::Mat& target, const ColourOverlapSettings& s) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("colour overlap: ") + what);
  };
  require(source.type() == CV_8UC1 || source.type() == CV_8UC3, "images must be 8-bit with 1 or 3 channels");
  require(!source.empty() && source.size() == target.size() && source.type() == target.type(),
          "both images must be of one size and type");
  lcmslam::check(s, "colour overlap");
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

// Where `sought`, a part of the reduced source, lies in the part `searched` of the reduced target.
struct Place {
  double coefficient = 0;
  cv::Point2d centre;  // reduced target
};

Place best_place(const cv::Mat& sought, const cv::Mat& target, const cv::Rect& searched) {
  cv::Mat coefficients;
  cv::matchTemplate(target(searched), sought, coefficients, cv::TM_CCOEFF_NORMED);
  cv::Point best;
  double coefficient = 0;
  cv::minMaxLoc(coefficients, nullptr, &coefficient, nullptr, &best);
  return {std::isfinite(coefficient) ? coefficient : 0,
          cv::Point2d(searched.x + best.x + 0.5 * sought.cols, searched.y + best.y + 0.5 * sought.rows)};
}

}  // namespace

ImageOverlap colour_overlap(const cv::Mat& source, const cv::Mat& target,
                            const ColourOverlapSettings& settings, const cv::Point2d& shift) {
  check(source, target, settings);
  const cv::Mat small_source = reduced_grey(source, settings.scale);
  const cv::Mat small_target = reduced_grey(target, settings.scale);
  const double scale = static_cast<double>(small_source.cols) / source.cols;
  std::vector<Segment> segments;
  for (int row = 0; row < settings.rows; ++row)
    for (int column = 0; column < settings.columns; ++column) {
      Segment& segment = segments.emplace_back();
      segment.area = segment_area(column, row, settings, source.size());
      const cv::Rect small = segment_area(column, row, settings, small_source.size());
      if (small.empty()) continue;
      const cv::Mat sought = small_source(small);
      if (!(contrast(sought) > settings.min_contrast)) continue;
      segment.state = SegmentState::outside;
      cv::Rect searched({0, 0}, small_target.size());
      if (settings.search > 0) {
        const int reach = static_cast<int>(std::ceil(scale * settings.search));
        const cv::Point corner(cvRound(small.x + scale * shift.x) - reach,
                               cvRound(small.y + scale * shift.y) - reach);
        searched &= cv::Rect(corner, small.size() + cv::Size(2 * reach, 2 * reach));
      }
      if (searched.width < small.width || searched.height < small.height) continue;
      const Place place = best_place(sought, small_target, searched);
      segment.coefficient = place.coefficient;
      segment.found = place.centre / scale;
      if (place.coefficient >= settings.threshold) segment.state = SegmentState::overlapping;
    }
  return ImageOverlap(source.size(), std::move(segments));
}

}  // namespace lcmslam
