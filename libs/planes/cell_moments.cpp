#include <lcmslam/planes/cell_moments.hpp>

#include <algorithm>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr int sums_of_cell = 10;

/// Adds a row of pixels to its columns' sums. Points count from a point of their cell: differences of squares
/// of metres would drown what makes a cell plane.
LCMSLAM_VECTORISED(add_row,
                   (const std::uint16_t* depth, const float* ray_x, const float* ray_y, const float* places,
                    int columns, float nearest, float farthest, float* sums),
                   (depth, ray_x, ray_y, places, columns, nearest, farthest, sums)) {
  float* __restrict n = sums;
  float* __restrict x = sums + columns;
  float* __restrict y = sums + 2 * columns;
  float* __restrict z = sums + 3 * columns;
  float* __restrict xx = sums + 4 * columns;
  float* __restrict xy = sums + 5 * columns;
  float* __restrict xz = sums + 6 * columns;
  float* __restrict yy = sums + 7 * columns;
  float* __restrict yz = sums + 8 * columns;
  float* __restrict zz = sums + 9 * columns;
  const float *place_x = places, *place_y = place_x + columns, *place_z = place_y + columns;
  for (int u = 0; u < columns; ++u) {
    const float metres = 0.001f * static_cast<float>(depth[u]);
    const float one = (metres >= nearest) & (metres <= farthest) ? 1.0f : 0.0f;
    const float px = one * (ray_x[u] * metres - place_x[u]), py = one * (ray_y[u] * metres - place_y[u]);
    const float dz = one * (metres - place_z[u]);
    n[u] += one;
    x[u] += px;
    y[u] += py;
    z[u] += dz;
    xx[u] += px * px;
    xy[u] += px * py;
    xz[u] += px * dz;
    yy[u] += py * py;
    yz[u] += py * dz;
    zz[u] += dz * dz;
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
  const cv::Mat rays = ray_table(camera);
  ray_x_.create(rays.size());
  ray_y_.create(rays.size());
  cv::Mat planes[] = {ray_x_, ray_y_};
  cv::split(rays, planes);
}

std::vector<PlaneMoments> CellMoments::operator()(const cv::Mat& depth) {
  const int width = columns_ * cell_;
  const auto stride = static_cast<std::size_t>(width);
  const auto nearest = static_cast<float>(calibration_.depth_min),
             farthest = static_cast<float>(calibration_.depth_max);
  std::vector<PlaneMoments> cells(static_cast<std::size_t>(columns_ * rows_));
  places_.resize(3 * stride);
  for (int row = 0; row < rows_; ++row) {
    sums_.assign(sums_of_cell * stride, 0.0f);
    const auto* middle = depth.ptr<std::uint16_t>(row * cell_ + cell_ / 2);
    for (int u = 0; u < width; ++u) {
      const int column = u / cell_ * cell_ + cell_ / 2;
      const Eigen::Vector3f place =
          point(row * cell_ + cell_ / 2, column, 0.001f * static_cast<float>(middle[column]));
      for (std::size_t axis = 0; axis < 3; ++axis)
        places_[axis * stride + static_cast<std::size_t>(u)] = place[static_cast<int>(axis)];
    }
    for (int v = row * cell_; v < (row + 1) * cell_; ++v)
      add_row(depth.ptr<std::uint16_t>(v), ray_x_.ptr<float>(v), ray_y_.ptr<float>(v), places_.data(), width,
              nearest, farthest, sums_.data());
    for (int column = 0; column < columns_; ++column) {
      double sums[sums_of_cell] = {};
      for (std::size_t k = 0; k < sums_of_cell; ++k)
        for (int i = 0; i < cell_; ++i)
          sums[k] += static_cast<double>(sums_[k * stride + static_cast<std::size_t>(column * cell_ + i)]);
      if (sums[0] <= 0) continue;
      PlaneMoments moments;
      moments.weight = moments.points = sums[0];
      moments.sum = {sums[1], sums[2], sums[3]};
      moments.squares << sums[4], sums[5], sums[6], sums[5], sums[7], sums[8], sums[6], sums[8], sums[9];
      Eigen::Isometry3d back = Eigen::Isometry3d::Identity();
      for (std::size_t axis = 0; axis < 3; ++axis)
        back.translation()[static_cast<int>(axis)] =
            static_cast<double>(places_[axis * stride + static_cast<std::size_t>(column * cell_)]);
      moments = moments.moved(back);
      const double sigma = calibration_.depth_noise.sigma(moments.sum.z() / moments.weight);
      cells[static_cast<std::size_t>(row * columns_ + column)] = moments.scaled(1 / (sigma * sigma));
    }
  }
  return cells;
}

}  // namespace lcmslam
