#include <lcmslam/imaging/depth_neighbours.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

constexpr float steepest = 5;     // depth over lateral distance: steeper is a step, not a surface
constexpr float farthest = 8192;  // pixels: no image is larger

}  // namespace

NeighbourCells::NeighbourCells(const std::vector<cv::Point2f>& queries, float footprint)
    : footprint_(footprint), cell_(neighbour_reach * footprint) {
  const auto inside = [](const cv::Point2f& query) {
    return query.x >= -0.5f && query.y >= -0.5f && query.x < farthest && query.y < farthest;
  };
  for (const auto& query : queries)
    if (inside(query)) {
      columns_ = std::max(columns_, cell(query.x) + 2);
      rows_ = std::max(rows_, cell(query.y) + 2);
    }
  wanted_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0);
  for (const auto& query : queries) {
    if (!inside(query)) continue;
    for (int y = std::max(0, cell(query.y) - 1); y <= cell(query.y) + 1; ++y)
      for (int x = std::max(0, cell(query.x) - 1); x <= cell(query.x) + 1; ++x) wanted_[index(x, y)] = 1;
  }
}

void NeighbourCells::add(float u, float v, float z, float sigma) {
  cells_.push_back(static_cast<int>(index(cell(u), cell(v))));
  points_.push_back({u, v, z, sigma});
}

// Counting sort.
void NeighbourCells::sort() {
  first_.assign(wanted_.size() + 1, 0);
  for (const int cell : cells_) ++first_[static_cast<std::size_t>(cell) + 1];
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  std::vector<int> next = first_;
  sorted_.resize(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i)
    sorted_[static_cast<std::size_t>(next[static_cast<std::size_t>(cells_[i])]++)] = points_[i];
}

void NeighbourCells::find(const cv::Point2f& query, std::vector<DepthNeighbour>& neighbours) const {
  neighbours.clear();
  const int x0 = cell(query.x), y0 = cell(query.y);
  for (int y = std::max(0, y0 - 1); y <= std::min(rows_ - 1, y0 + 1); ++y)
    for (int x = std::max(0, x0 - 1); x <= std::min(columns_ - 1, x0 + 1); ++x)
      for (int i = first_[index(x, y)]; i < first_[index(x, y) + 1]; ++i) {
        const Point& p = sorted_[static_cast<std::size_t>(i)];
        add_neighbour(query, footprint_, p.u, p.v, p.z, p.sigma, neighbours);
      }
}

// Inverse depth is linear in the pixel.
bool interpolate_depth(const std::vector<DepthNeighbour>& neighbours, float pitch, float pixel_sigma,
                       float& z, float& sigma) {
  const auto n = static_cast<float>(neighbours.size());
  if (neighbours.size() < 4) return false;
  float u = 0, v = 0, q = 0, variance = 0;
  for (const auto& p : neighbours) u += p.du, v += p.dv, q += p.q, variance += p.sigma * p.sigma;
  u /= n, v /= n, q /= n, variance /= n;
  // Neighbours on one side only: beyond the surface's end, or a hole.
  if (u * u + v * v > 0.75f * 0.75f) return false;

  float uu = 0, uv = 0, vv = 0, uq = 0, vq = 0;
  for (const auto& p : neighbours) {
    uu += (p.du - u) * (p.du - u), uv += (p.du - u) * (p.dv - v), vv += (p.dv - v) * (p.dv - v);
    uq += (p.du - u) * (p.q - q), vq += (p.dv - v) * (p.q - q);
  }
  const float determinant = uu * vv - uv * uv;
  if (!(determinant > 0.05f * (uu + vv) * (uu + vv))) return false;
  const float a = (vv * uq - uv * vq) / determinant;
  const float b = (uu * vq - uv * uq) / determinant;
  const float at_query = q - a * u - b * v;
  if (!(at_query > 0)) return false;
  z = 1 / at_query;

  // Depth step from one depth pixel to the next: dz = z^2 dq; lateral distance z * pitch.
  const float slope = std::sqrt(a * a + b * b) * z * z;
  const float noise = std::sqrt(variance);
  if (slope > steepest * z * pitch + 2 * noise) return false;
  for (const auto& p : neighbours) {
    const float residual = (p.q - q - a * (p.du - u) - b * (p.dv - v)) * z * z;
    if (std::abs(residual) > 3 * noise) return false;
  }
  sigma = std::sqrt(variance + slope * slope * pixel_sigma * pixel_sigma);
  return true;
}

}  // namespace lcmslam
