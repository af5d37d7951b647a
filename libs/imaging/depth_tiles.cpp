#include <lcmslam/imaging/depth_tiles.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float spare =
    0.5f;  // colour pixels: more than single precision and the lens's curve over a reach err

// Nearest and farthest valid depth of each column over some rows.
LCMSLAM_VECTORISED(take_range,
                   (const std::uint16_t* __restrict depth, int columns, std::uint16_t least,
                    std::uint16_t most, std::uint16_t* __restrict nearest,
                    std::uint16_t* __restrict farthest),
                   (depth, columns, least, most, nearest, farthest)) {
  for (int u = 0; u < columns; ++u) {
    const std::uint16_t mm = depth[u];
    const bool valid = (mm >= least) & (mm <= most);
    const std::uint16_t low = valid ? mm : std::uint16_t{65535}, high = valid ? mm : std::uint16_t{0};
    nearest[u] = low < nearest[u] ? low : nearest[u];
    farthest[u] = high > farthest[u] ? high : farthest[u];
  }
}

/// Of a row of tiles: nearest and farthest depth, m, and where in the ideal colour image their points lie.
struct TileRow {
  explicit TileRow(int tiles) {
    for (auto* values : {&nearest, &farthest, &left, &top, &right, &bottom})
      values->resize(static_cast<std::size_t>(tiles));
  }
  std::vector<float> nearest, farthest, left, top, right, bottom;
};

// The points z (x, y, 1) of a tile fill a part of a frustum with eight corners, which moves to another one; a
// perspective image keeps it within its corners' images. Where a corner lies behind the camera or nearly so,
// there is no bound.
LCMSLAM_VECTORISED(bound_tiles,
                   (const float* __restrict ray_left, const float* __restrict ray_top,
                    const float* __restrict ray_right, const float* __restrict ray_bottom,
                    const float* __restrict nearest, const float* __restrict farthest, int tiles,
                    const DepthRowGeometry& in, float* __restrict left, float* __restrict top,
                    float* __restrict right, float* __restrict bottom),
                   (ray_left, ray_top, ray_right, ray_bottom, nearest, farthest, tiles, in, left, top, right,
                    bottom)) {
  const DepthRowGeometry g = in;        // local: nothing that is written can change it
  constexpr float least_depth = 0.01f;  // m
  for (int i = 0; i < tiles; ++i) {
    float least_u = infinity, most_u = -infinity, least_v = infinity, most_v = -infinity;
    float least_z = infinity;
    for (int corner = 0; corner < 8; ++corner) {
      const float z = corner & 4 ? farthest[i] : nearest[i];
      const float x = z * (corner & 1 ? ray_right[i] : ray_left[i]);
      const float y = z * (corner & 2 ? ray_bottom[i] : ray_top[i]);
      const float depth = g.R[6] * x + g.R[7] * y + g.R[8] * z + g.t[2];
      const float inverse = 1 / depth;
      const float u = (g.R[0] * x + g.R[1] * y + g.R[2] * z + g.t[0]) * inverse;
      const float v = (g.R[3] * x + g.R[4] * y + g.R[5] * z + g.t[1]) * inverse;
      least_z = depth < least_z ? depth : least_z;
      least_u = u < least_u ? u : least_u;
      most_u = u > most_u ? u : most_u;
      least_v = v < least_v ? v : least_v;
      most_v = v > most_v ? v : most_v;
    }
    const bool bounded = least_z > least_depth;
    left[i] = bounded ? least_u : -infinity;
    right[i] = bounded ? most_u : infinity;
    top[i] = bounded ? least_v : -infinity;
    bottom[i] = bounded ? most_v : infinity;
  }
}

// Rectangles in the ideal image of which some cells are wanted: how many in any rectangle, in four look-ups.
class WantedGrid {
 public:
  WantedGrid(float left, float top, float right, float bottom, float cell)
      : left_(left),
        top_(top),
        per_unit_(1 / cell),
        columns_(steps(right - left)),
        rows_(steps(bottom - top)) {
    counts_.assign(static_cast<std::size_t>(columns_ + 1) * static_cast<std::size_t>(rows_ + 1), 0);
  }

  void want(float left, float top, float right, float bottom) {
    for (int y = row(top); y <= row(bottom); ++y)
      for (int x = column(left); x <= column(right); ++x) counts_[index(x + 1, y + 1)] = 1;
  }
  void sum() {
    for (int y = 1; y <= rows_; ++y)
      for (int x = 1; x <= columns_; ++x)
        counts_[index(x, y)] +=
            counts_[index(x - 1, y)] + counts_[index(x, y - 1)] - counts_[index(x - 1, y - 1)];
  }
  bool wants(float left, float top, float right, float bottom) const {
    if (!(right >= left_ && bottom >= top_ && column_number(left) < static_cast<float>(columns_) &&
          row_number(top) < static_cast<float>(rows_)))
      return false;
    const int x0 = column(left), x1 = column(right) + 1, y0 = row(top), y1 = row(bottom) + 1;
    return counts_[index(x1, y1)] - counts_[index(x0, y1)] - counts_[index(x1, y0)] + counts_[index(x0, y0)] >
           0;
  }

 private:
  static constexpr int most_steps = 1024;
  int steps(float length) const {
    return 1 + static_cast<int>(std::min(length * per_unit_, static_cast<float>(most_steps - 1)));
  }
  float column_number(float x) const { return (x - left_) * per_unit_; }
  float row_number(float y) const { return (y - top_) * per_unit_; }
  int column(float x) const {
    return static_cast<int>(std::clamp(column_number(x), 0.0f, static_cast<float>(columns_ - 1)));
  }
  int row(float y) const {
    return static_cast<int>(std::clamp(row_number(y), 0.0f, static_cast<float>(rows_ - 1)));
  }
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y * (columns_ + 1) + x); }

  float left_, top_, per_unit_;
  int columns_, rows_;
  std::vector<int> counts_;
};

}  // namespace

DepthTiles::DepthTiles(const CameraModel& colour, const cv::Mat& rays)
    : colour_(colour),
      columns_((rays.cols + tile_columns - 1) / tile_columns),
      rows_((rays.rows + tile_rows - 1) / tile_rows) {
  const auto tiles = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  for (auto* least : {&left_, &top_}) least->assign(tiles, infinity);
  for (auto* most : {&right_, &bottom_}) most->assign(tiles, -infinity);
  for (int v = 0; v < rays.rows; ++v)
    for (int u = 0; u < rays.cols; ++u) {
      const auto& ray = rays.at<cv::Vec2f>(v, u);
      const auto tile = static_cast<std::size_t>(v / tile_rows * columns_ + u / tile_columns);
      left_[tile] = std::min(left_[tile], ray[0]), right_[tile] = std::max(right_[tile], ray[0]);
      top_[tile] = std::min(top_[tile], ray[1]), bottom_[tile] = std::max(bottom_[tile], ray[1]);
    }
  // Where the lens spreads pixels most; between samples not much more.
  constexpr int samples = 32;
  constexpr double between_samples = 1.1;
  for (int j = 0; j <= samples; ++j)
    for (int i = 0; i <= samples; ++i) {
      const double u = (colour.width - 1.0) * i / samples, v = (colour.height - 1.0) * j / samples;
      const Eigen::Vector3d here = colour.ray({u, v});
      const Eigen::Vector3d by_u = (colour.ray({u + (i < samples ? 1.0 : -1.0), v}) - here).cwiseAbs();
      const Eigen::Vector3d by_v = (colour.ray({u, v + (j < samples ? 1.0 : -1.0)}) - here).cwiseAbs();
      const Eigen::Vector3d both = between_samples * (by_u + by_v);
      stretch_x_ = std::max(stretch_x_, static_cast<float>(both.x()));
      stretch_y_ = std::max(stretch_y_, static_cast<float>(both.y()));
    }
}

std::vector<char> DepthTiles::wanted_tiles(const cv::Mat& depth, const std::vector<cv::Point2f>& queries,
                                           float reach, const DepthRowGeometry& geometry) const {
  std::vector<char> wanted(left_.size(), 0);
  const float reach_x = (reach + spare) * stretch_x_, reach_y = (reach + spare) * stretch_y_;
  std::vector<cv::Point2f> ideal;
  struct {
    float left = infinity, top = infinity, right = -infinity, bottom = -infinity;
  } all;
  for (const cv::Point2f& query : queries) {
    if (!colour_.contains({query.x, query.y})) continue;
    const Eigen::Vector3f ray = colour_.ray({query.x, query.y}).cast<float>();
    if (!ray.allFinite()) continue;  // a rational lens may fold in a thin ring
    ideal.emplace_back(ray.x(), ray.y());
    all.left = std::min(all.left, ray.x() - reach_x), all.right = std::max(all.right, ray.x() + reach_x);
    all.top = std::min(all.top, ray.y() - reach_y), all.bottom = std::max(all.bottom, ray.y() + reach_y);
  }
  if (ideal.empty()) return wanted;
  constexpr float cell_pixels = 2;
  WantedGrid grid(all.left, all.top, all.right, all.bottom, cell_pixels / static_cast<float>(colour_.fx));
  for (const cv::Point2f& p : ideal) grid.want(p.x - reach_x, p.y - reach_y, p.x + reach_x, p.y + reach_y);
  grid.sum();

  const auto least = static_cast<std::uint16_t>(std::min(geometry.nearest, 65535.0f));
  const auto most = static_cast<std::uint16_t>(geometry.farthest);
  std::vector<std::uint16_t> nearest(static_cast<std::size_t>(depth.cols)), farthest(nearest);
  TileRow row(columns_);
  for (int y = 0; y < rows_; ++y) {
    std::fill(nearest.begin(), nearest.end(), std::uint16_t{65535});
    std::fill(farthest.begin(), farthest.end(), std::uint16_t{0});
    for (int v = y * tile_rows; v < std::min((y + 1) * tile_rows, depth.rows); ++v)
      take_range(depth.ptr<std::uint16_t>(v), depth.cols, least, most, nearest.data(), farthest.data());
    for (int x = 0; x < columns_; ++x) {
      std::uint16_t low = 65535, high = 0;
      for (int u = x * tile_columns; u < std::min((x + 1) * tile_columns, depth.cols); ++u) {
        low = std::min(low, nearest[static_cast<std::size_t>(u)]);
        high = std::max(high, farthest[static_cast<std::size_t>(u)]);
      }
      row.nearest[static_cast<std::size_t>(x)] = 0.001f * static_cast<float>(low);
      row.farthest[static_cast<std::size_t>(x)] = 0.001f * static_cast<float>(high);
    }
    const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_);
    bound_tiles(&left_[first], &top_[first], &right_[first], &bottom_[first], row.nearest.data(),
                row.farthest.data(), columns_, geometry, row.left.data(), row.top.data(), row.right.data(),
                row.bottom.data());
    for (std::size_t x = 0; x < row.left.size(); ++x) {
      const bool measured = row.nearest[x] <= row.farthest[x];
      wanted[first + x] =
          measured && grid.wants(row.left[x], row.top[x], row.right[x], row.bottom[x]) ? 1 : 0;
    }
  }
  return wanted;
}

}  // namespace lcmslam
