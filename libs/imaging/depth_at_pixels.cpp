#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/imaging/depth_registration.hpp>

namespace lcmslam {
namespace {

// One registered depth point near a query.
struct Neighbour {
  float du, dv;  // colour pixels from the query, in units of the footprint
  float q;       // 1 / z
  float sigma;   // m
};

constexpr float search_radius = 1.5f;  // depth pixels
constexpr float steepest = 5;          // depth over lateral distance: steeper is a step, not a surface

// Which depth points lie near a colour position. Aligned images: the 3 x 3 pixels around it. Otherwise
// points are sorted into square cells, but only those that a query looks into.
class NeighbourSearch {
 public:
  NeighbourSearch(const RegisteredDepth& registered, const std::vector<cv::Point2f>& queries)
      : registered_(registered), cell_(search_radius * registered.footprint) {
    if (!registered.aligned && !registered.points.empty()) sort_into_cells(queries);
  }

  void find(const cv::Point2f& query, std::vector<Neighbour>& neighbours) const {
    neighbours.clear();
    if (registered_.aligned) {
      const int u0 = static_cast<int>(std::lround(query.x));
      const int v0 = static_cast<int>(std::lround(query.y));
      for (int v = std::max(0, v0 - 1); v <= std::min(registered_.points.rows - 1, v0 + 1); ++v)
        for (int u = std::max(0, u0 - 1); u <= std::min(registered_.points.cols - 1, u0 + 1); ++u)
          add(query, v * registered_.points.cols + u, neighbours);
    } else {
      const int x0 = cell(query.x);
      const int y0 = cell(query.y);
      for (int y = std::max(0, y0 - 1); y <= std::min(rows_ - 1, y0 + 1); ++y)
        for (int x = std::max(0, x0 - 1); x <= std::min(columns_ - 1, x0 + 1); ++x)
          for (int i = first_[index(x, y)]; i < first_[index(x, y) + 1]; ++i)
            add(query, sorted_[static_cast<std::size_t>(i)], neighbours);
    }
  }

 private:
  int cell(float position) const { return static_cast<int>(std::floor((position + 0.5f) / cell_)); }
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y * columns_ + x); }

  void add(const cv::Point2f& query, int point, std::vector<Neighbour>& neighbours) const {
    const float z = registered_.points.ptr<cv::Vec3f>()[point][2];
    if (std::isnan(z)) return;
    const cv::Vec2f pixel = registered_.aligned
                                ? cv::Vec2f(static_cast<float>(point % registered_.points.cols),
                                            static_cast<float>(point / registered_.points.cols))
                                : registered_.pixels.ptr<cv::Vec2f>()[point];
    const float du = (pixel[0] - query.x) / registered_.footprint;
    const float dv = (pixel[1] - query.y) / registered_.footprint;
    if (!(du * du + dv * dv <= search_radius * search_radius)) return;
    neighbours.push_back({du, dv, 1 / z, registered_.sigma.ptr<float>()[point]});
  }

  // Counting sort.
  void sort_into_cells(const std::vector<cv::Point2f>& queries) {
    float right = 0;
    float bottom = 0;
    for (const auto& query : queries) right = std::max(right, query.x), bottom = std::max(bottom, query.y);
    columns_ = cell(std::min(right, 8192.0f)) + 2;
    rows_ = cell(std::min(bottom, 8192.0f)) + 2;
    std::vector<char> wanted(static_cast<std::size_t>(columns_ * rows_), 0);
    for (const auto& query : queries) {
      if (!(query.x >= -0.5f && query.y >= -0.5f && query.x < 8192 && query.y < 8192)) continue;
      for (int y = std::max(0, cell(query.y) - 1); y <= cell(query.y) + 1; ++y)
        for (int x = std::max(0, cell(query.x) - 1); x <= cell(query.x) + 1; ++x) wanted[index(x, y)] = 1;
    }
    const auto* pixels = registered_.pixels.ptr<cv::Vec2f>();
    const int count = static_cast<int>(registered_.pixels.total());
    std::vector<std::pair<int, int>> entries;  // cell, point
    for (int i = 0; i < count; ++i) {
      if (std::isnan(pixels[i][0])) continue;
      const int x = cell(pixels[i][0]);
      const int y = cell(pixels[i][1]);
      if (x < columns_ && y < rows_ && wanted[index(x, y)])
        entries.emplace_back(static_cast<int>(index(x, y)), i);
    }
    first_.assign(wanted.size() + 1, 0);
    for (const auto& entry : entries) ++first_[static_cast<std::size_t>(entry.first) + 1];
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    std::vector<int> next = first_;
    sorted_.resize(entries.size());
    for (const auto& entry : entries)
      sorted_[static_cast<std::size_t>(next[static_cast<std::size_t>(entry.first)]++)] = entry.second;
  }

  const RegisteredDepth& registered_;
  float cell_;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<int> first_;
  std::vector<int> sorted_;
};

// Depth and standard deviation at the query, from the plane through its neighbours (inverse depth is
// linear in the pixel); false where there is no such plane.
bool interpolate_depth(const std::vector<Neighbour>& neighbours, float pitch, float pixel_sigma, float& z,
                       float& sigma) {
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

}  // namespace

std::vector<DepthAtPixel> depth_at_pixels(const RegisteredDepth& registered,
                                          const RgbdCalibration& calibration,
                                          const std::vector<cv::Point2f>& colour_pixels) {
  constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
  std::vector<DepthAtPixel> result(colour_pixels.size(), {Eigen::Vector3f::Constant(nothing), nothing});
  const NeighbourSearch search(registered, colour_pixels);
  const auto pixel_sigma = static_cast<float>(calibration.pixel_sigma) / registered.footprint;
  std::vector<Neighbour> neighbours;
  for (std::size_t i = 0; i < colour_pixels.size(); ++i) {
    const cv::Point2f& pixel = colour_pixels[i];
    if (!calibration.colour.contains({pixel.x, pixel.y})) continue;  // also refuses NaN
    search.find(pixel, neighbours);
    float z = 0;
    float sigma = 0;
    if (!interpolate_depth(neighbours, registered.pitch, pixel_sigma, z, sigma)) continue;
    const Eigen::Vector3d ray = calibration.colour.ray({pixel.x, pixel.y});
    result[i] = {(static_cast<double>(z) * ray).cast<float>(), sigma};
  }
  return result;
}

}  // namespace lcmslam
