#include <lcmslam/surface/colour_lookup.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr float hidden_behind = 1.04f;  // times the depth of what is in front

// NaN is seen by no pixel: comparisons with it are false.
LCMSLAM_VECTORISED(find_colour_pixels,
                   (const float* points, int count, const Lens& lens, std::int32_t* rows,
                    std::int32_t* columns),
                   (points, count, lens, rows, columns)) {
  const Lens by_value = lens;
  for (int i = 0; i < count; ++i) {
    const Lens::Place place = by_value.place(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    rows[i] = static_cast<int>(place.v);
    columns[i] = static_cast<int>(place.u);
  }
}

/// i / cell for every i below `size`.
std::vector<int> cells_of(int size, int cell) {
  std::vector<int> cells(static_cast<std::size_t>(size));
  for (int i = 0; i < size; ++i) cells[static_cast<std::size_t>(i)] = i / cell;
  return cells;
}

}  // namespace

void look_up_colours(const cv::Mat& points, const cv::Mat& colour, const Lens& lens, float footprint,
                     cv::Mat& found, cv::Mat& seen) {
  cv::Mat_<std::int32_t> rows(points.size()), columns(points.size());
  for (int v = 0; v < points.rows; ++v)
    find_colour_pixels(points.ptr<float>(v), points.cols, lens, rows[v], columns[v]);

  // The nearest depth in cells of the colour image that no two neighbouring points can both leave out.
  const int cell = std::max(1, static_cast<int>(std::ceil(1.5f * footprint)));
  const std::vector<int> cell_rows = cells_of(colour.rows, cell), cell_columns = cells_of(colour.cols, cell);
  cv::Mat_<float> nearest(colour.rows / cell + 1, colour.cols / cell + 1, 1e9f);
  const auto cell_of = [&](int row, int column) -> float& {
    return nearest[cell_rows[static_cast<std::size_t>(row)]][cell_columns[static_cast<std::size_t>(column)]];
  };
  for (int v = 0; v < points.rows; ++v) {
    const auto* point = points.ptr<cv::Vec3f>(v);
    for (int u = 0; u < points.cols; ++u) {
      if (rows[v][u] < 0) continue;
      float& depth = cell_of(rows[v][u], columns[v][u]);
      depth = std::min(depth, point[u][2]);
    }
  }
  for (int v = 0; v < points.rows; ++v) {
    const auto* point = points.ptr<cv::Vec3f>(v);
    for (int u = 0; u < points.cols; ++u) {
      const int row = rows[v][u], column = columns[v][u];
      if (row < 0 || point[u][2] > hidden_behind * cell_of(row, column)) continue;
      found.ptr<cv::Vec3b>(v)[u] = colour.ptr<cv::Vec3b>(row)[column];
      seen.ptr<std::uint8_t>(v)[u] = 255;
    }
  }
}

}  // namespace lcmslam
