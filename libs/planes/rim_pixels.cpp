#include <lcmslam/planes/rim_pixels.hpp>

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/planes/point_sums.hpp>

namespace lcmslam {
namespace {

constexpr int lanes = PointSums::lanes;
constexpr float nobodys = -1;  // sigma

struct Pixels {
  const float *x, *y, *z, *sigma;
  int count;
};

struct RowOfPixels {
  const std::uint16_t* depth;                // mm
  const float *ray_x, *ray_y, *sigma_of_mm;  // x/z, y/z; m
  float max_sigma;
  int count;
};

LCMSLAM_VECTORISED(load_row,
                   (const RowOfPixels& row, float* __restrict x, float* __restrict y, float* __restrict z,
                    float* __restrict sigma),
                   (row, x, y, z, sigma)) {
  const RowOfPixels r = row;
  for (int i = 0; i < r.count; ++i) {
    z[i] = 0.001f * static_cast<float>(r.depth[i]);
    x[i] = z[i] * r.ray_x[i];
    y[i] = z[i] * r.ray_y[i];
    const float known = r.sigma_of_mm[r.depth[i]];
    sigma[i] = known <= r.max_sigma ? known : nobodys;
  }
}

LCMSLAM_VECTORISED(take_pixels,
                   (const Pixels& pixels, const NearPlane& plane, const std::int32_t* __restrict bulge,
                    float gate, float* __restrict along, std::int32_t* __restrict own),
                   (pixels, plane, bulge, gate, along, own)) {
  const Pixels p = pixels;
  const NearPlane n = plane;
  const std::int32_t label = n.label;
  for (int i = 0; i < p.count; ++i) {
    const float off = n.x * p.x[i] + n.y * p.y[i] + n.z * p.z[i] + n.offset;
    const float here = n.offset / (n.offset - off), other = along[i];
    const std::int32_t shape = bulge[own[i]];
    const bool nearer = std::abs(here - 1) < std::abs(other - 1);
    const bool first = ((shape > 0) & (here > other)) | ((shape < 0) & (here < other)) |
                       ((shape == 0) & nearer) | (own[i] == 0);
    const bool takes = (std::abs(off) < gate * p.sigma[i]) & first;
    along[i] = takes ? here : other;
    own[i] = takes ? label : own[i];
  }
}

struct SurePixels {
  NearPlane plane;
  float gate;
  float place_x, place_y, place_z;  // m, of one of them
};

/// Sums as those of CellMoments, of the pixels that lie in the plane for sure.
LCMSLAM_VECTORISED(add_sure,
                   (const Pixels& pixels, const std::int32_t* labels, const SurePixels& sure,
                    float* __restrict sums),
                   (pixels, labels, sure, sums)) {
  const Pixels p = pixels;
  const SurePixels s = sure;
  const std::int32_t label = s.plane.label;
  PointSums points;
  for (int start = 0; start < p.count; start += lanes)
    for (int l = 0; l < lanes; ++l) {
      const int i = start + l;
      const float off = s.plane.x * p.x[i] + s.plane.y * p.y[i] + s.plane.z * p.z[i] + s.plane.offset;
      const float one = ((labels[i] == label) & (std::abs(off) <= s.gate * p.sigma[i])) ? 1.0f : 0.0f;
      const float dx = one * (p.x[i] - s.place_x), dy = one * (p.y[i] - s.place_y),
                  dz = one * (p.z[i] - s.place_z);
      points.add(l, one, dx, dy, dz);
    }
  for (int k = 0; k < sums_of_points; ++k)
    for (int l = 0; l < lanes; ++l) sums[k] += points.of(k)[l];
}

}  // namespace

RimPixels::RimPixels(const CellMoments& cells, double max_sigma)
    : cells_(cells),
      max_sigma_(static_cast<float>(max_sigma)),
      count_(static_cast<std::size_t>((cells.side() * cells.side() + lanes - 1) / lanes * lanes)),
      x_(count_),
      y_(count_),
      z_(count_),
      sigma_(count_, nobodys),
      along_(count_),
      own_(count_),
      labels_(count_) {}

void RimPixels::load(const cv::Mat& depth, int column, int row) {
  const int side = cells_.side(), u = column * side;
  std::size_t first = 0;
  for (int v = row * side; v < (row + 1) * side; ++v, first += static_cast<std::size_t>(side))
    load_row({depth.ptr<std::uint16_t>(v) + u, cells_.ray_x(v) + u, cells_.ray_y(v) + u, cells_.sigmas(),
              max_sigma_, side},
             &x_[first], &y_[first], &z_[first], &sigma_[first]);
  std::fill(own_.begin(), own_.end(), 0);
}

void RimPixels::offer(const NearPlane& plane, const std::int32_t* bulge, float gate) {
  take_pixels({x_.data(), y_.data(), z_.data(), sigma_.data(), static_cast<int>(count_)}, plane, bulge, gate,
              along_.data(), own_.data());
}

void RimPixels::write(cv::Mat& labels, int column, int row) const {
  const int side = cells_.side();
  const std::int32_t* own = own_.data();
  for (int v = row * side; v < (row + 1) * side; ++v, own += side)
    std::transform(own, own + side, labels.ptr<std::uint8_t>(v) + column * side,
                   [](std::int32_t label) { return static_cast<std::uint8_t>(label); });
}

PlaneMoments RimPixels::moments_of(const NearPlane& plane, const cv::Mat& labels, int column, int row,
                                   float gate) {
  const int side = cells_.side();
  std::int32_t* to = labels_.data();
  for (int v = row * side; v < (row + 1) * side; ++v, to += side) {
    const auto* from = labels.ptr<std::uint8_t>(v) + column * side;
    std::copy(from, from + side, to);
  }
  const auto first = static_cast<std::size_t>(
      std::find(labels_.begin(), labels_.end(), std::int32_t{plane.label}) - labels_.begin());
  if (first == count_) return {};
  std::array<float, sums_of_points> sums{};
  add_sure({x_.data(), y_.data(), z_.data(), sigma_.data(), static_cast<int>(count_)}, labels_.data(),
           {plane, gate, x_[first], y_[first], z_[first]}, sums.data());
  std::array<double, sums_of_points> exact;
  std::copy(sums.begin(), sums.end(), exact.begin());
  return moments_about({x_[first], y_[first], z_[first]}, exact);
}

cv::Mat without_smoothed(const cv::Mat& labels, int reach) {
  const cv::Mat cross = cv::getStructuringElement(cv::MORPH_CROSS, {2 * reach + 1, 2 * reach + 1});
  cv::Mat highest, lowest = labels | (labels == 0);  // where there is no plane 255
  cv::dilate(labels, highest, cross);
  cv::erode(lowest, lowest, cross);
  return labels & (highest == labels) & (lowest == labels);
}

}  // namespace lcmslam
