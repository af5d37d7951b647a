#include <lcmslam/map_layers/carving_view.hpp>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace lcmslam {
namespace {

constexpr float beyond = 1e3f;       // m: farther than anything
constexpr double most_holes = 0.65;  // of the pixels around one

}  // namespace

void CarvingView::set(const cv::Mat& depth, const CameraModel& camera) {
  if (depth.cols != camera.width || depth.rows != camera.height)
    throw std::invalid_argument("a depth image of " + std::to_string(depth.cols) + " x " +
                                std::to_string(depth.rows) + " pixels; the camera has " +
                                std::to_string(camera.width) + " x " + std::to_string(camera.height));
  if (depth.type() != CV_32FC1 && depth.type() != CV_16UC1 && depth.type() != CV_16SC1)
    throw std::invalid_argument("a depth image of OpenCV's type " + std::to_string(depth.type()) +
                                "; must be CV_32FC1 (m), CV_16UC1 or CV_16SC1 (mm)");
  const bool same = camera.width == camera_.width && camera.height == camera_.height &&
                    camera.fx == camera_.fx && camera.fy == camera_.fy && camera.cx == camera_.cx &&
                    camera.cy == camera_.cy && camera.distortion == distortion_;
  if (!same) {
    camera.check("camera");
    camera_ = camera;
    distortion_ = camera.distortion;
    camera_.distortion.clear();
    undistort();
  }
  depth.convertTo(raw_, CV_32F, depth.type() == CV_32FC1 ? 1.0 : 0.001);
  if (depth.type() == CV_32FC1)
    for (int v = 0; v < raw_.rows; ++v) {
      auto* row = raw_.ptr<float>(v);
      for (int u = 0; u < raw_.cols; ++u) row[u] = std::isfinite(row[u]) ? row[u] : 0.0f;
    }
  if (source_.empty()) {
    depth_ = raw_;
  } else {
    depth_.create(raw_.size(), CV_32F);
    const auto* from = raw_.ptr<float>();
    auto* to = depth_.ptr<float>();
    for (std::size_t i = 0; i < source_.size(); ++i) to[i] = source_[i] >= 0 ? from[source_[i]] : 0.0f;
  }
  nearest_[0] = cv::abs(depth_);
  find_nearest();
  find_extremes();
}

// A hole among pixels with depth tells nothing, and the others decide: at the edges of what stands far
// behind, and where a surface is seen at a flat angle, every window has holes. Where most are holes nobody
// sees through.
void CarvingView::find_nearest() {
  nearest_[0].copyTo(filled_);
  cv::compare(filled_, 0, hole_, cv::CMP_EQ);
  filled_.setTo(beyond, hole_);
  for (std::size_t level = 1; level < nearest_.size(); ++level) {
    const int side = 2 * (radii[level] - radii[level - 1]) + 1, whole = 2 * radii[level] + 1;
    cv::erode(filled_, filled_, cv::Mat::ones(side, side, CV_8U));
    cv::boxFilter(hole_, holes_, CV_8U, {whole, whole});  // 255: all
    filled_.copyTo(nearest_[level]);
    nearest_[level].setTo(0, holes_ > 255 * most_holes);
  }
}

int CarvingView::level_for(float radius) {
  const auto found =
      std::find_if(radii.begin(), radii.end() - 1, [&](int r) { return static_cast<float>(r) >= radius; });
  return static_cast<int>(found - radii.begin());
}

void CarvingView::undistort() {
  source_.clear();
  if (distortion_.empty()) return;
  CameraModel measured = camera_;
  measured.distortion = distortion_;
  source_.reserve(static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height));
  for (int v = 0; v < camera_.height; ++v)
    for (int u = 0; u < camera_.width; ++u) {
      const auto pixel = measured.project(camera_.ray({u, v}));
      const bool seen = pixel && measured.contains(*pixel);
      const int x = seen ? static_cast<int>(std::lround(pixel->x())) : 0;
      const int y = seen ? static_cast<int>(std::lround(pixel->y())) : 0;
      const bool inside = seen && x >= 0 && y >= 0 && x < camera_.width && y < camera_.height;
      source_.push_back(inside ? y * camera_.width + x : -1);
    }
}

void CarvingView::find_extremes() {
  const cv::Mat& depth = nearest_[0];
  tiles_.create((depth.rows + tile - 1) / tile, (depth.cols + tile - 1) / tile);
  farthest_ = 0;
  for (int y = 0; y < tiles_.rows; ++y)
    for (int x = 0; x < tiles_.cols; ++x) {
      const cv::Rect all(0, 0, depth.cols, depth.rows);
      double least = 0, most = 0;
      cv::minMaxIdx(depth(cv::Rect(x * tile, y * tile, tile, tile) & all), &least, &most);
      tiles_(y, x) = {static_cast<float>(least), static_cast<float>(most)};
      farthest_ = std::max(farthest_, tiles_(y, x)[1]);
    }
}

CarvingView::Extremes CarvingView::extremes(const Eigen::Vector2i& first, const Eigen::Vector2i& last) const {
  Extremes found{tiles_(first.y() / tile, first.x() / tile)[0], 0};
  for (int y = first.y() / tile; y <= last.y() / tile; ++y)
    for (int x = first.x() / tile; x <= last.x() / tile; ++x) {
      found.least = std::min(found.least, tiles_(y, x)[0]);
      found.most = std::max(found.most, tiles_(y, x)[1]);
    }
  return found;
}

}  // namespace lcmslam
