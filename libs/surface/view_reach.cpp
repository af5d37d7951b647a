#include <lcmslam/surface/view_reach.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

constexpr float close = 0.05f;     // m; nearer, directions change too much within a block
constexpr float rounding = 0.02f;  // pixels

struct Interval {
  float low, high;
};

/// Of x / z, for x within `half` around `middle`.
Interval slopes(float middle, float half, float near, float far) {
  const float low = middle - half, high = middle + half;
  return {low / (low < 0 ? near : far), high / (high > 0 ? near : far)};
}

float greatest_size(const Interval& i) {
  return std::max(std::abs(i.low), std::abs(i.high));
}

}  // namespace

ViewReach::ViewReach(const SurfaceView& view, const Eigen::Matrix3f& R_depth_map, const VoxelBlocks& blocks)
    : view_(view),
      half_(R_depth_map.cwiseAbs() *
            Eigen::Vector3f::Constant(0.5f * (VoxelBlock::side - 1) * blocks.voxel_size())),
      truncation_(blocks.truncation()) {}

bool ViewReach::holds(const Eigen::Vector3f& centre) const {
  const float near = centre.z() - half_.z(), far = centre.z() + half_.z();
  if (far <= 0) return false;
  const Lens& lens = view_.lens;
  if (near < close) {
    const Eigen::Vector2f aside = (centre.head<2>().cwiseAbs() - half_.head<2>()).cwiseMax(0);
    return aside.squaredNorm() <= lens.widest * far * far;
  }
  const Interval x = slopes(centre.x(), half_.x(), near, far), y = slopes(centre.y(), half_.y(), near, far);
  const float bend = lens.bend * (greatest_size(x) + greatest_size(y));
  const float wider_u = lens.fx * bend + rounding, wider_v = lens.fy * bend + rounding;
  return holds_tiles(lens.fx * x.low + lens.cx - wider_u, lens.fx * x.high + lens.cx + wider_u,
                     lens.fy * y.low + lens.cy - wider_v, lens.fy * y.high + lens.cy + wider_v, near);
}

bool ViewReach::holds_tiles(float left, float right, float top, float bottom, float nearest) const {
  if (!(right >= 0 && bottom >= 0 && left < view_.lens.width && top < view_.lens.height)) return false;
  const auto tile_of = [](float pixel, int tiles) {
    return std::min(static_cast<int>(std::max(pixel, 0.0f)) / SurfaceView::tile, tiles - 1);
  };
  const int last_row = tile_of(std::min(bottom, view_.lens.height), view_.farthest.rows),
            last_column = tile_of(std::min(right, view_.lens.width), view_.farthest.cols),
            first_column = tile_of(left, view_.farthest.cols);
  for (int row = tile_of(top, view_.farthest.rows); row <= last_row; ++row) {
    const float *farthest = view_.farthest[row], *flattest = view_.flattest[row];
    for (int column = first_column; column <= last_column; ++column)
      if (farthest[column] > 0 && nearest <= farthest[column] + truncation_ * flattest[column]) return true;
  }
  return false;
}

}  // namespace lcmslam
