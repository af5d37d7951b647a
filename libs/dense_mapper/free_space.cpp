#include <lcmslam/dense_mapper/free_space.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lcmslam {
namespace {

constexpr float nearest_z = 0.1f;  // m
constexpr float spacings = 1.5f;   // between points that a cell is wide: none stays empty on a surface
constexpr float widest = 200;      // cells
constexpr float least_cosine = 0.25f;
constexpr float steepest = 10;  // x / z, y / z

inline bool usable(const Eigen::Vector3f& p) {
  const float most = steepest * p.z();  // comparisons that NaN fails
  return p.z() >= nearest_z && std::isfinite(most) && std::abs(p.x()) <= most && std::abs(p.y()) <= most;
}

}  // namespace

FreeSpaceView::FreeSpaceView(const Cloud& cloud, const FreeSpaceSettings& settings) : settings_(settings) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  Eigen::Array2f low(inf, inf), high(-inf, -inf);
  std::size_t count = 0;
  for (const Eigen::Vector3f& p : cloud.points) {
    if (!usable(p)) continue;
    const Eigen::Array2f direction = p.head<2>().array() / p.z();
    low = low.min(direction);
    high = high.max(direction);
    ++count;
  }
  if (count < 2) return;
  const Eigen::Array2f extent = high - low;
  pitch_ =
      std::max(spacings * std::sqrt(extent.prod() / static_cast<float>(count)), extent.maxCoeff() / widest);
  if (!(pitch_ > 0)) return;
  left_ = low.x();
  top_ = low.y();
  columns_ = 1 + static_cast<int>(extent.x() / pitch_);
  rows_ = 1 + static_cast<int>(extent.y() / pitch_);
  near_.assign(index(0, rows_), 0);
  far_.assign(near_.size(), 0);

  const auto k = static_cast<float>(settings.sigmas);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    if (!usable(p)) continue;
    const float u = (p.x() / p.z() - left_) / pitch_, v = (p.y() / p.z() - top_) / pitch_;
    if (!is_inside(u, v)) continue;
    const float spread = cloud.sigmas.empty() || !std::isfinite(cloud.sigmas[i]) ? 0 : k * cloud.sigmas[i];
    const std::size_t cell = index(static_cast<int>(u), static_cast<int>(v));
    const float z = std::max(p.z() - spread, 0.01f);
    near_[cell] = near_[cell] > 0 ? std::min(near_[cell], z) : z;
    far_[cell] = std::max(far_[cell], p.z() + spread);
  }
  around_[0] = nearest_around(near_, 1);
  around_[1] = nearest_around(around_[0], 1);
  around_[2] = nearest_around(around_[1], 2);
}

// Rows, then columns; beyond the image nothing is known.
std::vector<float> FreeSpaceView::nearest_around(const std::vector<float>& image, int radius) const {
  using Image = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const Image> given(image.data(), rows_, columns_);
  std::vector<float> result(image.size(), 0);
  const int width = columns_ - 2 * radius, height = rows_ - 2 * radius;
  if (width <= 0 || height <= 0) return result;
  Image across = given.middleCols(radius, width);
  for (int d = -radius; d <= radius; ++d) across = across.min(given.middleCols(radius + d, width));
  Eigen::Map<Image> nearest(result.data(), rows_, columns_);
  auto inner = nearest.block(radius, radius, height, width);
  inner = across.middleRows(radius, height);
  for (int d = -radius; d <= radius; ++d) inner = inner.min(across.middleRows(radius + d, height));
  return result;
}

Eigen::Vector3f FreeSpaceView::ray(int column, int row) const {
  return {left_ + pitch_ * (static_cast<float>(column) + 0.5f),
          top_ + pitch_ * (static_cast<float>(row) + 0.5f), 1};
}

Visibility FreeSpaceView::judge(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const {
  if (columns_ == 0 || !(point.z() >= nearest_z)) return Visibility::unknown;
  const float u = (point.x() / point.z() - left_) / pitch_;
  const float v = (point.y() / point.z() - top_) / pitch_;
  if (!is_inside(u, v)) return Visibility::unknown;
  const std::size_t cell = index(static_cast<int>(u), static_cast<int>(v));
  // A surface that errs by the tolerance across it errs by more along a slanting ray.
  const float cosine = std::max(least_cosine, std::abs(normal.dot(point)) / point.norm());
  const float margin = static_cast<float>(settings_.tolerance) / cosine;
  const float radius = static_cast<float>(settings_.lateral) / (point.z() * pitch_);
  const auto& around = around_[radius <= 1 ? 0 : radius <= 2 ? 1 : 2];
  if (point.z() + margin < around[cell]) return Visibility::seen_through;
  if (near_[cell] == 0) return Visibility::unknown;
  if (point.z() - margin >= far_[cell]) return Visibility::hidden;
  return point.z() + margin > near_[cell] ? Visibility::supported : Visibility::unknown;
}

}  // namespace lcmslam
