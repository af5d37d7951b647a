#include <lcmslam/rgbd/edge_offset.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr int small_width = 320;     // pixels of the image that is looked at
constexpr int reach = 20, step = 1;  // small pixels, to each side
constexpr int shifts = 2 * (reach / step) + 1;
constexpr std::array<double, 9> scales = {0.84, 0.88, 0.92, 0.96, 1, 1.04, 1.08, 1.12, 1.16};
constexpr std::size_t unchanged = 4;       // of scales
constexpr float jump = 0.08f;              // of the depth: an edge
constexpr std::size_t most_points = 1500;  // of a frame

std::size_t cell(std::size_t scale, int right, int down) {
  return (scale * shifts + static_cast<std::size_t>(down / step + reach / step)) * shifts +
         static_cast<std::size_t>(right / step + reach / step);
}

static_assert(step == 1, "a row of shifts is a row of pixels");
LCMSLAM_VECTORISED(add_row, (const float* strength, double* sums), (strength, sums)) {
  for (int i = 0; i < shifts; ++i) sums[i] += static_cast<double>(strength[i]);
}

/// Small pixels beyond the image to which a shifted edge may come, `middle` pixels from its border.
int border_of(double middle) {
  return reach + static_cast<int>(std::ceil((scales.back() - 1) * middle)) + 2;
}

/// The strength of colour edges in a small grey image, each frame's mean 1: bright frames do not outweigh
/// others.
cv::Mat gradient(const cv::Mat& colour, double pixel) {
  cv::Mat grey, small, dx, dy, strength;
  cv::cvtColor(colour, grey, cv::COLOR_BGR2GRAY);
  cv::resize(grey, small, {}, 1 / pixel, 1 / pixel, cv::INTER_AREA);
  cv::Scharr(small, dx, CV_32F, 1, 0);
  cv::Scharr(small, dy, CV_32F, 0, 1);
  cv::magnitude(dx, dy, strength);
  cv::sqrt(strength, strength);  // a few strong edges do not decide
  cv::GaussianBlur(strength, strength, {5, 5}, 1.2);
  const double mean = cv::mean(strength)[0];
  return mean > 0 ? cv::Mat(strength / mean) : cv::Mat();
}

/// The first depth beside a pixel, m; NaN when there is none near. Cameras see nothing right beside an edge.
float depth_beside(const cv::Mat& points, int row, int column, int down, int right) {
  const int gap = 1 + points.cols / 100;
  for (int k = 1; k <= gap; ++k) {
    const int r = row + k * down, c = column + k * right;
    if (r < 0 || c < 0 || r >= points.rows || c >= points.cols) break;
    const float z = points.at<cv::Vec3f>(r, c)[2];
    if (std::isfinite(z)) return z;
  }
  return std::numeric_limits<float>::quiet_NaN();
}

/// False beside no depth.
bool is_edge(const cv::Mat& points, int row, int column) {
  const float here = points.at<cv::Vec3f>(row, column)[2];
  if (!std::isfinite(here)) return false;
  for (const auto& [down, right] : {std::pair(0, -1), std::pair(0, 1), std::pair(-1, 0), std::pair(1, 0)})
    if (depth_beside(points, row, column, down, right) - here > jump * here) return true;
  return false;
}

/// Where the near sides of depth's jumps lie in the colour image.
std::vector<cv::Point2f> edge_pixels(const RegisteredDepth& depth) {
  std::vector<cv::Point2f> found;
  for (int row = 0; row < depth.points.rows; ++row)
    for (int column = 0; column < depth.points.cols; ++column) {
      if (!is_edge(depth.points, row, column)) continue;
      cv::Point2f pixel(static_cast<float>(column), static_cast<float>(row));
      if (!depth.aligned) pixel = depth.pixels.at<cv::Point2f>(row, column);
      if (std::isfinite(pixel.x) && std::isfinite(pixel.y)) found.push_back(pixel);
    }
  return found;
}

}  // namespace

EdgeOffset::EdgeOffset() : sums_(scales.size() * shifts * shifts, 0.0) {}

void EdgeOffset::add(const RgbdFrame& frame, const RegisteredDepth& depth) {
  pixel_ = std::max(1.0, static_cast<double>(frame.colour.cols) / small_width);
  const cv::Mat strength = gradient(frame.colour, pixel_);
  const std::vector<cv::Point2f> edges = edge_pixels(depth);
  if (strength.empty() || edges.empty()) return;
  const double middle_x = 0.5 * strength.cols, middle_y = 0.5 * strength.rows;
  // What falls off the image says nothing: it counts as the image's mean.
  const int border_x = border_of(middle_x), border_y = border_of(middle_y);
  cv::Mat around;
  cv::copyMakeBorder(strength, around, border_y, border_y, border_x, border_x, cv::BORDER_CONSTANT,
                     cv::Scalar::all(1));
  for (std::size_t i = 0; i < edges.size(); i += edges.size() / most_points + 1) {
    ++points_;
    mean_ += 1;
    for (std::size_t scale = 0; scale < scales.size(); ++scale) {
      const int x = static_cast<int>(middle_x + scales[scale] * (edges[i].x / pixel_ - middle_x));
      const int y = static_cast<int>(middle_y + scales[scale] * (edges[i].y / pixel_ - middle_y));
      for (int down = -reach; down <= reach; down += step)
        add_row(around.ptr<float>(y + down + border_y) + x - reach + border_x,
                &sums_[cell(scale, -reach, down)]);
    }
  }
}

EdgeOffset::Best EdgeOffset::best() const {
  Best best;
  if (points_ == 0) return best;
  const double here = sums_[cell(unchanged, 0, 0)] / mean_ - 1;
  double most = here;
  for (std::size_t scale = 0; scale < scales.size(); ++scale)
    for (int down = -reach; down <= reach; down += step)
      for (int right = -reach; right <= reach; right += step) {
        const double above_mean = sums_[cell(scale, right, down)] / mean_ - 1;
        if (above_mean <= most) continue;
        most = above_mean;
        best.scale = scales[scale];
        best.right = right * pixel_;
        best.down = down * pixel_;
      }
  best.contrast = 1 + most;
  best.gain = most / std::max(here, 0.01);
  return best;
}

}  // namespace lcmslam
