#include <lcmslam/map_layers/carving_view.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr float beyond = 1e3f;       // m: farther than anything
constexpr double most_holes = 0.65;  // of the pixels around one
constexpr int border = CarvingView::radii.back();
static_assert((2 * border + 1) * (2 * border + 1) < 256, "a window's holes are counted in a byte");

/// A place beyond an edge is the one as far inside of it.
int mirrored(int at, int size) {
  while (at < 0 || at >= size) at = size == 1 ? 0 : at < 0 ? -at : 2 * (size - 1) - at;
  return at;
}

LCMSLAM_VECTORISED(fill_holes,
                   (const float* __restrict depth, int columns, float* __restrict nearest,
                    float* __restrict filled, std::uint8_t* __restrict is_hole),
                   (depth, columns, nearest, filled, is_hole)) {
  for (int u = 0; u < columns; ++u) {
    const float near = std::abs(depth[u]);
    nearest[u] = near;
    filled[u] = near == 0 ? beyond : near;
    is_hole[u] = near == 0 ? 1 : 0;
  }
}

LCMSLAM_VECTORISED(add_row, (const std::uint8_t* __restrict row, int columns, std::uint8_t* __restrict sum),
                   (row, columns, sum)) {
  for (int u = 0; u < columns; ++u) sum[u] = static_cast<std::uint8_t>(sum[u] + row[u]);
}

LCMSLAM_VECTORISED(take_row, (const std::uint8_t* __restrict row, int columns, std::uint8_t* __restrict sum),
                   (row, columns, sum)) {
  for (int u = 0; u < columns; ++u) sum[u] = static_cast<std::uint8_t>(sum[u] - row[u]);
}

LCMSLAM_VECTORISED(take_nearer, (const float* __restrict row, int columns, float* __restrict nearest),
                   (row, columns, nearest)) {
  for (int u = 0; u < columns; ++u) nearest[u] = row[u] < nearest[u] ? row[u] : nearest[u];
}

// The last of the two directions: `above` and `holes` are of columns, with borders.
LCMSLAM_VECTORISED(look_along,
                   (const float* __restrict above, int reach, const std::uint8_t* __restrict holes,
                    int radius, int most, int columns, float* __restrict filled, float* __restrict nearest),
                   (above, reach, holes, radius, most, columns, filled, nearest)) {
  constexpr int piece = 64;
  for (int first = 0; first < columns; first += piece) {
    const int n = std::min(piece, columns - first);
    float least[piece];
    std::uint8_t count[piece] = {};
    for (int i = 0; i < n; ++i) least[i] = above[first + i];
    for (int k = -reach; k <= reach; ++k)
      for (int i = 0; i < n; ++i) {
        const float other = above[first + i + k];
        least[i] = other < least[i] ? other : least[i];
      }
    for (int k = -radius; k <= radius; ++k)
      for (int i = 0; i < n; ++i) count[i] = static_cast<std::uint8_t>(count[i] + holes[first + i + k]);
    for (int i = 0; i < n; ++i) {
      filled[first + i] = least[i];
      nearest[first + i] = count[i] > most ? 0.0f : least[i];
    }
  }
}

// Of some rows: the nearest and the farthest of each column.
LCMSLAM_VECTORISED(widen,
                   (const float* __restrict row, int columns, float* __restrict least,
                    float* __restrict most),
                   (row, columns, least, most)) {
  for (int u = 0; u < columns; ++u) {
    least[u] = row[u] < least[u] ? row[u] : least[u];
    most[u] = row[u] > most[u] ? row[u] : most[u];
  }
}

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
  find_nearest();
  find_extremes();
}

// A hole among pixels with depth tells nothing, and the others decide: at the edges of what stands far
// behind, and where a surface is seen at a flat angle, every window has holes. Where most are holes nobody
// sees through. Windows grow from level to level: the nearest of the former level's, and all holes anew.
void CarvingView::find_nearest() {
  const int rows = depth_.rows, columns = depth_.cols;
  for (cv::Mat& level : nearest_) level.create(depth_.size(), CV_32F);
  hole_.create(depth_.size(), CV_8U);                          // 1: no depth
  holes_.create(1, columns + 2 * border, CV_8U);               // of a column's rows around one
  filled_.create(2 * rows + 1, columns + 2 * border, CV_32F);  // two levels, and as holes_: the nearest
  for (int v = 0; v < rows; ++v)
    fill_holes(depth_.ptr<float>(v), columns, nearest_[0].ptr<float>(v), filled_.ptr<float>(v),
               hole_.ptr<std::uint8_t>(v));
  std::uint8_t* const holes = holes_.ptr<std::uint8_t>() + border;
  float* const above = filled_.ptr<float>(2 * rows) + border;
  const auto hole = [&](int v) { return hole_.ptr<std::uint8_t>(mirrored(v, rows)); };
  for (std::size_t level = 1; level < nearest_.size(); ++level) {
    const int radius = radii[level], more = radius - radii[level - 1];
    const int most = static_cast<int>(most_holes * (2 * radius + 1) * (2 * radius + 1));
    const auto from = [&](int v) { return filled_.ptr<float>(level % 2 != 0 ? v : rows + v); };
    const auto to = [&](int v) { return filled_.ptr<float>(level % 2 != 0 ? rows + v : v); };
    std::fill(holes, holes + columns, std::uint8_t{0});
    for (int v = -radius; v < radius; ++v) add_row(hole(v), columns, holes);
    for (int v = 0; v < rows; ++v) {
      add_row(hole(v + radius), columns, holes);
      for (int u = 1; u <= radius; ++u) {
        holes[-u] = holes[mirrored(-u, columns)];
        holes[columns - 1 + u] = holes[mirrored(columns - 1 + u, columns)];
      }
      std::copy(from(v), from(v) + columns, above);
      for (int j = std::max(0, v - more); j <= std::min(rows - 1, v + more); ++j)
        if (j != v) take_nearer(from(j), columns, above);
      std::fill(above - more, above, beyond);
      std::fill(above + columns, above + columns + more, beyond);
      look_along(above, more, holes, radius, most, columns, to(v), nearest_[level].ptr<float>(v));
      take_row(hole(v - radius), columns, holes);
    }
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
  std::vector<float> least(static_cast<std::size_t>(depth.cols)), most(least.size());
  for (int y = 0; y < tiles_.rows; ++y) {
    std::copy_n(depth.ptr<float>(y * tile), depth.cols, least.begin());
    most = least;
    for (int v = y * tile + 1; v < std::min((y + 1) * tile, depth.rows); ++v)
      widen(depth.ptr<float>(v), depth.cols, least.data(), most.data());
    for (int x = 0; x < tiles_.cols; ++x) {
      const int first = x * tile, end = std::min(first + tile, depth.cols);
      tiles_(y, x) = {*std::min_element(least.begin() + first, least.begin() + end),
                      *std::max_element(most.begin() + first, most.begin() + end)};
      farthest_ = std::max(farthest_, tiles_(y, x)[1]);
    }
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
