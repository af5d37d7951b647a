#include <lcmslam/planes/plane_grid.hpp>

#include <algorithm>
#include <climits>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace lcmslam {
namespace {

constexpr double farthest_place = 1000;  // m
constexpr int spare = 32;                // cells on each side, so that growing is rare
constexpr int split = 3;  // of a cell for outlines: they run through the middles of the outermost parts

}  // namespace

void PlaneGrid::add(const std::vector<Eigen::Vector2d>& places) {
  std::vector<cv::Point> cells;
  cells.reserve(places.size());
  int left = INT_MAX, top = INT_MAX, right = INT_MIN, bottom = INT_MIN;
  for (const Eigen::Vector2d& place : places) {
    if (!(place.cwiseAbs().maxCoeff() < farthest_place)) continue;
    const cv::Point c(static_cast<int>(std::floor(place.x() / cell_)),
                      static_cast<int>(std::floor(place.y() / cell_)));
    left = std::min(left, c.x);
    right = std::max(right, c.x);
    top = std::min(top, c.y);
    bottom = std::max(bottom, c.y);
    cells.push_back(c);
  }
  if (cells.empty()) return;
  reach(left, top, right, bottom);
  for (const cv::Point& c : cells) {
    std::uint8_t& hits = hits_(c.y - top_, c.x - left_);
    hits = static_cast<std::uint8_t>(std::min(hits + 1, 255));
  }
}

void PlaneGrid::reach(int left, int top, int right, int bottom) {
  const bool inside = !hits_.empty() && left >= left_ && top >= top_ && right < left_ + hits_.cols &&
                      bottom < top_ + hits_.rows;
  if (inside) return;
  if (!hits_.empty()) {
    left = std::min(left, left_);
    top = std::min(top, top_);
    right = std::max(right, left_ + hits_.cols - 1);
    bottom = std::max(bottom, top_ + hits_.rows - 1);
  }
  left -= spare;
  top -= spare;
  cv::Mat_<std::uint8_t> larger(bottom - top + 1 + spare, right - left + 1 + spare, std::uint8_t{0});
  if (!hits_.empty()) hits_.copyTo(larger(cv::Rect(left_ - left, top_ - top, hits_.cols, hits_.rows)));
  hits_ = larger;
  left_ = left;
  top_ = top;
}

std::vector<PlaneGrid::Part> PlaneGrid::parts(int hits) const {
  std::vector<Part> parts;
  if (hits_.empty()) return parts;
  cv::Mat taken = hits_ >= hits, closed, large;
  cv::morphologyEx(taken, closed, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  // Each part within its own box: a map's planes have hundreds of specks.
  cv::Mat labels, boxes, centroids;
  const int count = cv::connectedComponentsWithStats(closed, labels, boxes, centroids, 4, CV_32S);
  for (int part = 1; part < count; ++part) {
    const cv::Rect box(boxes.at<int>(part, cv::CC_STAT_LEFT), boxes.at<int>(part, cv::CC_STAT_TOP),
                       boxes.at<int>(part, cv::CC_STAT_WIDTH), boxes.at<int>(part, cv::CC_STAT_HEIGHT));
    cv::resize(labels(box) == part, large, {}, split, split, cv::INTER_NEAREST);
    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(large, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    std::vector<cv::Point> simple;
    cv::approxPolyDP(contours.front(), simple, split * 0.75, true);
    if (simple.size() < 3) continue;
    Part found;
    found.area = boxes.at<int>(part, cv::CC_STAT_AREA) * cell_ * cell_;
    for (const cv::Point& p : simple)
      found.outline.emplace_back(cell_ * (left_ + box.x + (p.x + 0.5) / split),
                                 cell_ * (top_ + box.y + (p.y + 0.5) / split));
    double twice = 0;  // the signed area
    for (std::size_t i = 0; i < found.outline.size(); ++i) {
      const Eigen::Vector2d &a = found.outline[i], &b = found.outline[(i + 1) % found.outline.size()];
      twice += a.x() * b.y() - a.y() * b.x();
    }
    if (twice < 0) std::reverse(found.outline.begin(), found.outline.end());
    parts.push_back(std::move(found));
  }
  return parts;
}

}  // namespace lcmslam
