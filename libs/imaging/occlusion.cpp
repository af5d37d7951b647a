#include <lcmslam/imaging/occlusion.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

struct CellGeometry {
  float per_pixel, half;  // cells a colour pixel, colour pixels
  int span, margin;       // cells
  int stride;             // cells from row to row
};

inline int floor_of(float value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < static_cast<float>(truncated) ? 1 : 0);
}

// Where the windows of a row's points begin: the first one, and how far the last ones lie to the right and
// down (0 where one window does). -1 for points without pixel.
LCMSLAM_VECTORISED(find_windows,
                   (const float* __restrict u, const float* __restrict v, int columns, const CellGeometry& in,
                    std::int32_t* __restrict first, std::int32_t* __restrict right,
                    std::int32_t* __restrict down),
                   (u, v, columns, in, first, right, down)) {
  const CellGeometry g = in;  // local: nothing that is written can change it
  for (int i = 0; i < columns; ++i) {
    const bool seen = u[i] >= -0.5f;  // not NaN
    const float x = seen ? u[i] : 0.0f, y = seen ? v[i] : 0.0f;
    const int left = floor_of((x - g.half + 0.5f) * g.per_pixel);
    const int end = floor_of((x + g.half + 0.5f) * g.per_pixel);
    const int top = floor_of((y - g.half + 0.5f) * g.per_pixel);
    const int bottom = floor_of((y + g.half + 0.5f) * g.per_pixel);
    first[i] = seen ? (top + g.margin) * g.stride + left + g.margin : -1;
    right[i] = std::max(0, end - left + 1 - g.span);
    down[i] = std::max(0, bottom - top + 1 - g.span) * g.stride;
  }
}

// Each pixel's cell, as at() finds it; 0 for points without pixel: no window begins so far up and left.
LCMSLAM_VECTORISED(cells_of_row,
                   (const float* __restrict pixel, int columns, const CellGeometry& in,
                    std::int32_t* __restrict cell),
                   (pixel, columns, in, cell)) {
  const CellGeometry g = in;  // local: nothing that is written can change it
  for (int i = 0; i < columns; ++i) {
    const float u = pixel[2 * i], v = pixel[2 * i + 1];
    const bool seen = u >= -0.5f;  // not NaN
    const int column = static_cast<int>(((seen ? u : 0.0f) + 0.5f) * g.per_pixel) + g.margin;
    const int row = static_cast<int>(((seen ? v : 0.0f) + 0.5f) * g.per_pixel) + g.margin;
    cell[i] = seen ? row * g.stride + column : 0;
  }
}

LCMSLAM_VECTORISED(take_minimum, (const float* __restrict other, int columns, float* __restrict row),
                   (other, columns, row)) {
  for (int i = 0; i < columns; ++i) row[i] = other[i] < row[i] ? other[i] : row[i];
}

inline void lower(float& cell, float z) {
  cell = z < cell ? z : cell;
}

}  // namespace

DepthBuffer::DepthBuffer(cv::Size colour_size, float footprint)
    : per_pixel_(1 / std::max(1.0f, 0.5f * footprint)),
      half_(0.6f * footprint),  // a little over one half: slanted surfaces spread
      span_(static_cast<int>(2 * half_ * per_pixel_) + 1),
      margin_(span_ + 1) {
  const auto cells = [&](int pixels) {
    return static_cast<int>(static_cast<float>(pixels) * per_pixel_) + 2 + 2 * margin_;
  };
  nearest_.create(cells(colour_size.height), cells(colour_size.width));
  std::fill_n(nearest_.ptr<float>(), nearest_.total(), infinity);
}

void DepthBuffer::splat(const float* u, const float* v, const float* z, int columns) {
  const auto count = static_cast<std::size_t>(columns);
  if (first_.size() < count)
    for (auto* values : {&first_, &right_, &down_}) values->resize(count);
  const CellGeometry geometry{per_pixel_, half_, span_, margin_, nearest_.cols};
  find_windows(u, v, columns, geometry, first_.data(), right_.data(), down_.data());
  auto* const cells = nearest_.ptr<float>();
  const std::int32_t *first = first_.data(), *right = right_.data(), *down = down_.data();
  for (std::size_t i = 0; i < count; ++i) {
    if (first[i] < 0) continue;
    float* const window = cells + first[i];
    lower(window[0], z[i]);
    lower(window[right[i]], z[i]);  // without asking whether it is another one: that changes all the time
    if (down[i] == 0) continue;
    lower(window[down[i]], z[i]);
    lower(window[right[i] + down[i]], z[i]);
  }
}

// From the last row and column backwards, so that minima are taken of what was put in.
void DepthBuffer::close() {
  std::vector<float> copy(static_cast<std::size_t>(nearest_.cols));
  for (int y = nearest_.rows - 1; y >= 0; --y) {
    auto* row = nearest_.ptr<float>(y);
    for (int above = 1; above < span_ && above <= y; ++above)
      take_minimum(nearest_.ptr<float>(y - above), nearest_.cols, row);
    std::copy(row, row + nearest_.cols, copy.begin());
    for (int before = 1; before < span_; ++before)
      take_minimum(copy.data(), nearest_.cols - before, row + before);
  }
}

void DepthBuffer::find_cells(const float* pixel, int columns, std::int32_t* cell) const {
  cells_of_row(pixel, columns, {per_pixel_, half_, span_, margin_, nearest_.cols}, cell);
}

float smaller_step(float before, float z, float after) {
  const float a = std::abs(z - before);
  const float b = std::abs(after - z);
  if (std::isnan(a)) return std::isnan(b) ? 0.0f : b;
  return std::isnan(b) ? a : std::min(a, b);
}

void hide_occluded(RegisteredDepth& registered, const DepthBuffer& buffer, int step) {
  constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
  const int rows = registered.points.rows, columns = registered.points.cols;
  std::vector<std::int32_t> cells(static_cast<std::size_t>(columns));
  for (int v = 0; v < rows; v += step) {
    const auto* point = registered.points.ptr<cv::Vec3f>(v);
    const auto* above = v > 0 ? registered.points.ptr<cv::Vec3f>(v - 1) : nullptr;
    const auto* below = v + 1 < rows ? registered.points.ptr<cv::Vec3f>(v + 1) : nullptr;
    const auto* sigma = registered.sigma.ptr<float>(v);
    auto* pixel = registered.pixels.ptr<cv::Vec2f>(v);
    buffer.find_cells(registered.pixels.ptr<float>(v), columns, cells.data());
    for (int u = 0; u < columns; u += step) {
      const float z = point[u][2];
      const float gap = gap_before(buffer.in(cells[static_cast<std::size_t>(u)]), z, sigma[u]);
      if (!(gap > 0)) continue;
      const float horizontal =
          smaller_step(u > 0 ? point[u - 1][2] : nothing, z, u + 1 < columns ? point[u + 1][2] : nothing);
      const float vertical = smaller_step(above ? above[u][2] : nothing, z, below ? below[u][2] : nothing);
      if (is_hidden(gap, step, horizontal, vertical)) pixel[u] = {nothing, nothing};
    }
  }
}

}  // namespace lcmslam
