#include <lcmslam/planes/plane_grid.hpp>

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace lcmslam {
namespace {

constexpr double farthest_place = 1000;  // m
constexpr int spare = 32;                // cells on each side, so that growing is rare
constexpr int split = 3;  // of a cell for outlines: they run through the middles of the outermost parts

}  // namespace

/// The cells of a box, for which there is room from then on.
cv::Rect PlaneGrid::reach(const Eigen::AlignedBox2d& box) {
  const Eigen::AlignedBox2d near = box.intersection(Eigen::AlignedBox2d(
      Eigen::Vector2d::Constant(-farthest_place), Eigen::Vector2d::Constant(farthest_place)));
  if (near.isEmpty()) return {};
  const Eigen::Array2i from = (near.min() / cell_).array().floor().cast<int>(),
                       to = (near.max() / cell_).array().floor().cast<int>() + 1;
  const cv::Rect area(from.x(), from.y(), to.x() - from.x(), to.y() - from.y());
  const cv::Rect have(left_, top_, seen_.cols, seen_.rows);
  if ((area & have) == area) return area;
  const cv::Rect all = area | have;
  cv::Mat_<std::uint8_t> larger(all.height + 2 * spare, all.width + 2 * spare, std::uint8_t{0});
  left_ = all.x - spare;
  top_ = all.y - spare;
  if (!seen_.empty()) seen_.copyTo(larger(have - cv::Point(left_, top_)));
  seen_ = larger;
  return area;
}

std::vector<PlaneGrid::Part> PlaneGrid::parts() const {
  std::vector<Part> parts;
  if (seen_.empty()) return parts;
  cv::Mat taken = seen_ >= static_cast<double>(looks_), closed, large;
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
