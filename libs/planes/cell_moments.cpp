#include <lcmslam/planes/cell_moments.hpp>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/planes/point_sums.hpp>

namespace lcmslam {
namespace {

constexpr int lanes = PointSums::lanes;

/// Rows of pixels, from the first one on.
struct PixelRows {
  const std::uint16_t* depth;                // mm
  const float *ray_x, *ray_y;                // x/z, y/z
  std::ptrdiff_t depth_pitch, ray_pitch;     // from row to row
  const float *place_x, *place_y, *place_z;  // m, of a point of each column's cell
  float nearest, farthest;                   // m
  int rows, columns;
};

/// The sums of each column over the rows. Points count from a point of their cell. Some columns at once, so
/// that their sums stay in registers; the last ones perhaps twice.
LCMSLAM_VECTORISED(add_rows, (const PixelRows& pixels, float* __restrict sums), (pixels, sums)) {
  const PixelRows p = pixels;
  for (int start = 0; start < p.columns; start += lanes) {
    const int first = start + lanes <= p.columns ? start : p.columns - lanes;
    PointSums points;
    for (int v = 0; v < p.rows; ++v) {
      const std::uint16_t* depth = p.depth + v * p.depth_pitch + first;
      const float *ray_x = p.ray_x + v * p.ray_pitch + first, *ray_y = p.ray_y + v * p.ray_pitch + first;
      for (int l = 0; l < lanes; ++l) {
        const float metres = 0.001f * static_cast<float>(depth[l]);
        const float one = ((metres >= p.nearest) & (metres <= p.farthest)) ? 1.0f : 0.0f;
        const float dx = one * (ray_x[l] * metres - p.place_x[first + l]);
        const float dy = one * (ray_y[l] * metres - p.place_y[first + l]);
        const float dz = one * (metres - p.place_z[first + l]);
        points.add(l, one, dx, dy, dz);
      }
    }
    for (int k = 0; k < sums_of_points; ++k)
      for (int l = 0; l < lanes; ++l) sums[k * p.columns + first + l] = points.of(k)[l];
  }
}

}  // namespace

CellMoments::CellMoments(const RgbdCalibration& calibration, int cell)
    : calibration_(calibration), cell_(cell), columns_(0), rows_(0) {
  if (calibration_.depth_registered) calibration_.depth = calibration_.colour;
  calibration_.check();
  const CameraModel& camera = calibration_.depth;
  columns_ = camera.width / cell;
  rows_ = camera.height / cell;
  if (columns_ * cell < lanes)
    throw std::invalid_argument("planes: cells of " + std::to_string(cell) + " pixels in images of " +
                                std::to_string(camera.width) + ": together they must be at least " +
                                std::to_string(lanes) + " wide");
  const cv::Mat rays = ray_table(camera);
  ray_x_.create(rays.size());
  ray_y_.create(rays.size());
  cv::Mat planes[] = {ray_x_, ray_y_};
  cv::split(rays, planes);
  sigmas_.assign(1 << 16, std::numeric_limits<float>::infinity());
  for (std::size_t mm = 1; mm < sigmas_.size(); ++mm) {
    const double z = 0.001 * static_cast<double>(mm);
    if (z >= calibration_.depth_min && z <= calibration_.depth_max)
      sigmas_[mm] = static_cast<float>(sigma(z));
  }
}

std::vector<PlaneMoments> CellMoments::operator()(const cv::Mat& depth) {
  const int width = columns_ * cell_;
  const auto stride = static_cast<std::size_t>(width);
  const auto nearest = static_cast<float>(calibration_.depth_min),
             farthest = static_cast<float>(calibration_.depth_max);
  std::vector<PlaneMoments> cells(static_cast<std::size_t>(columns_ * rows_));
  places_.resize(3 * stride);
  sums_.resize(sums_of_points * stride);
  for (int row = 0; row < rows_; ++row) {
    const auto* middle = depth.ptr<std::uint16_t>(row * cell_ + cell_ / 2);
    for (int u = 0; u < width; ++u) {
      const int column = u / cell_ * cell_ + cell_ / 2;
      const Eigen::Vector3f place =
          point(row * cell_ + cell_ / 2, column, 0.001f * static_cast<float>(middle[column]));
      for (std::size_t axis = 0; axis < 3; ++axis)
        places_[axis * stride + static_cast<std::size_t>(u)] = place[static_cast<int>(axis)];
    }
    const int top = row * cell_;
    const PixelRows pixels{depth.ptr<std::uint16_t>(top),
                           ray_x_.ptr<float>(top),
                           ray_y_.ptr<float>(top),
                           static_cast<std::ptrdiff_t>(depth.step1()),
                           static_cast<std::ptrdiff_t>(ray_x_.step1()),
                           places_.data(),
                           places_.data() + stride,
                           places_.data() + 2 * stride,
                           nearest,
                           farthest,
                           cell_,
                           width};
    add_rows(pixels, sums_.data());
    for (int column = 0; column < columns_; ++column) {
      std::array<double, sums_of_points> sums{};
      for (std::size_t k = 0; k < sums_of_points; ++k)
        for (int i = 0; i < cell_; ++i)
          sums[k] += static_cast<double>(sums_[k * stride + static_cast<std::size_t>(column * cell_ + i)]);
      if (sums[0] <= 0) continue;
      Eigen::Vector3d place;
      for (std::size_t axis = 0; axis < 3; ++axis)
        place[static_cast<int>(axis)] =
            static_cast<double>(places_[axis * stride + static_cast<std::size_t>(column * cell_)]);
      const PlaneMoments moments = moments_about(place, sums);
      cells[static_cast<std::size_t>(row * columns_ + column)] =
          moments.weighed(sigma(moments.sum.z() / moments.weight));
    }
  }
  return cells;
}

}  // namespace lcmslam
