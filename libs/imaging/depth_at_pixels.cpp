#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <lcmslam/imaging/depth_neighbours.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/imaging/depth_rows.hpp>
#include <lcmslam/imaging/depth_tiles.hpp>
#include <lcmslam/imaging/occlusion.hpp>

namespace lcmslam {
namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

struct Footprint {
  float pitch = 0;      // rad between depth pixels
  float footprint = 1;  // colour pixels between them
};

// `find(query, neighbours)` gives the depth points around a query.
template <class Find>
std::vector<DepthAtPixel> interpolate(const std::vector<cv::Point2f>& queries,
                                      const RgbdCalibration& calibration, const Footprint& depth,
                                      const Find& find) {
  std::vector<DepthAtPixel> result(queries.size(), {Eigen::Vector3f::Constant(nan_value), nan_value});
  const auto pixel_sigma = static_cast<float>(calibration.pixel_sigma) / depth.footprint;
  std::vector<DepthNeighbour> neighbours;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const cv::Point2f& pixel = queries[i];
    if (!calibration.colour.contains({pixel.x, pixel.y})) continue;  // also refuses NaN
    find(pixel, neighbours);
    float z = 0;
    float sigma = 0;
    if (!interpolate_depth(neighbours, depth.pitch, pixel_sigma, z, sigma)) continue;
    const Eigen::Vector3d ray = calibration.colour.ray({pixel.x, pixel.y});
    if (!ray.allFinite()) continue;  // the lens folds there
    result[i] = {(static_cast<double>(z) * ray).cast<float>(), sigma};
  }
  return result;
}

// The 3 x 3 pixels around a query, where depth pixels are colour's own. `row(v, u0, n)` gives the points and
// sigmas of n pixels of a row from u0 on.
template <class Row>
void find_own(const cv::Point2f& query, cv::Size size, const Row& row,
              std::vector<DepthNeighbour>& neighbours) {
  neighbours.clear();
  const int u0 = static_cast<int>(std::lround(query.x)), v0 = static_cast<int>(std::lround(query.y));
  const int left = std::max(0, u0 - 1), right = std::min(size.width - 1, u0 + 1);
  for (int v = std::max(0, v0 - 1); v <= std::min(size.height - 1, v0 + 1); ++v) {
    const auto [point, sigma] = row(v, left, right - left + 1);
    for (int u = left; u <= right; ++u) {
      const float z = point[3 * (u - left) + 2];
      if (!std::isnan(z))
        add_neighbour(query, 1, static_cast<float>(u), static_cast<float>(v), z, sigma[u - left], neighbours);
    }
  }
}

// Depth points whose place in the colour image is known, but not yet whether something hides them.
struct Candidate {
  float u, v, z, sigma;
  int column, row;  // of the depth image
};

// Depth along colour's optical axis, as unproject_row() and move_row() have it; NaN outside of the image.
class MovedDepth {
 public:
  MovedDepth(const cv::Mat& depth, const cv::Mat& rays, const DepthRowGeometry& geometry)
      : depth_(depth), rays_(rays), geometry_(geometry) {}
  float operator()(int column, int row) const {
    if (column < 0 || row < 0 || column >= depth_.cols || row >= depth_.rows) return nan_value;
    float point[3], sigma = 0;
    unproject_row(depth_.ptr<std::uint16_t>(row) + column, nullptr, rays_.ptr<float>(row) + 2 * column, 1,
                  geometry_, point, &sigma);
    move_row(1, geometry_, point);
    return point[2];
  }

 private:
  const cv::Mat &depth_, &rays_;
  const DepthRowGeometry& geometry_;
};

}  // namespace

std::vector<DepthAtPixel> depth_at_pixels(const RegisteredDepth& registered,
                                          const RgbdCalibration& calibration,
                                          const std::vector<cv::Point2f>& colour_pixels) {
  const Footprint depth{registered.pitch, registered.footprint};
  if (registered.aligned) {
    const auto row = [&](int v, int u, int) {
      return std::pair(registered.points.ptr<float>(v) + 3 * u, registered.sigma.ptr<float>(v) + u);
    };
    return interpolate(colour_pixels, calibration, depth, [&](const auto& query, auto& neighbours) {
      find_own(query, registered.points.size(), row, neighbours);
    });
  }
  NeighbourCells cells(colour_pixels, registered.footprint);
  for (int v = 0; v < registered.pixels.rows; ++v) {
    const auto* pixel = registered.pixels.ptr<cv::Vec2f>(v);
    const auto* point = registered.points.ptr<cv::Vec3f>(v);
    const auto* sigma = registered.sigma.ptr<float>(v);
    for (int u = 0; u < registered.pixels.cols; ++u)
      if (!std::isnan(pixel[u][0]) && cells.wants(pixel[u][0], pixel[u][1]))
        cells.add(pixel[u][0], pixel[u][1], point[u][2], sigma[u]);
  }
  cells.sort();
  return interpolate(colour_pixels, calibration, depth,
                     [&](const auto& query, auto& neighbours) { cells.find(query, neighbours); });
}

std::vector<DepthAtPixel> DepthRegistration::depth_at_pixels(
    const RgbdFrame& frame, const std::vector<cv::Point2f>& colour_pixels,
    const Eigen::Isometry3d& T_colour_depth_time) const {
  if (!T_colour_depth_time.matrix().allFinite())
    throw std::invalid_argument("T_colour_depth_time must be finite");
  if (frame.depth.empty() || colour_pixels.empty())
    return std::vector<DepthAtPixel>(colour_pixels.size(), {Eigen::Vector3f::Constant(nan_value), nan_value});
  check_frame(frame, calibration_);
  const Eigen::Isometry3d T = T_colour_depth_time * calibration_.T_colour_depth;
  const DepthRowGeometry geometry = depth_row_geometry(calibration_, T);
  const Footprint depth{static_cast<float>(1 / calibration_.depth.fx),
                        static_cast<float>(calibration_.colour.fx / calibration_.depth.fx)};
  std::vector<float> points(3 * static_cast<std::size_t>(frame.depth.cols));
  std::vector<float> sigmas(static_cast<std::size_t>(frame.depth.cols));
  const auto measure = [&](int v, int u, int n) {
    unproject_row(frame.depth.ptr<std::uint16_t>(v) + u,
                  frame.amplitude.empty() ? nullptr : frame.amplitude.ptr<std::uint8_t>(v) + u,
                  rays_.ptr<float>(v) + 2 * u, n, geometry, points.data(), sigmas.data());
    return std::pair(points.data(), sigmas.data());
  };
  if (calibration_.depth_registered && T_colour_depth_time.matrix().isIdentity(0))
    return interpolate(colour_pixels, calibration_, depth, [&](const auto& query, auto& neighbours) {
      find_own(query, frame.depth.size(), measure, neighbours);
    });

  NeighbourCells cells(colour_pixels, depth.footprint);
  const CameraModel& colour = calibration_.colour;
  DepthBuffer buffer({colour.width, colour.height}, depth.footprint);
  const LensRowGeometry lens = lens_row_geometry(colour);
  std::vector<float> u(sigmas.size()), v(u), z(u);
  std::vector<Candidate> candidates;
  // What lies around queries, and what may hide that.
  const float reach = neighbour_reach * depth.footprint + buffer.reach();
  tiles_.around(frame.depth, colour_pixels, reach, geometry, [&](int row, int first, int columns) {
    measure(row, first, columns);
    move_row(columns, geometry, points.data());
    project_row(points.data(), columns, lens, u.data(), v.data(), z.data());
    buffer.splat(u.data(), v.data(), z.data(), columns);
    for (int i = 0; i < columns; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (u[at] >= -0.5f && cells.wants(u[at], v[at]))
        candidates.push_back({u[at], v[at], z[at], sigmas[at], first + i, row});
    }
  });
  buffer.close();
  const MovedDepth moved(frame.depth, rays_, geometry);
  for (const Candidate& c : candidates) {
    const float gap = gap_before(buffer.at(c.u, c.v), c.z, c.sigma);
    if (gap > 0 &&
        is_hidden(gap, 1, smaller_step(moved(c.column - 1, c.row), c.z, moved(c.column + 1, c.row)),
                  smaller_step(moved(c.column, c.row - 1), c.z, moved(c.column, c.row + 1))))
      continue;
    cells.add(c.u, c.v, c.z, c.sigma);
  }
  cells.sort();
  return interpolate(colour_pixels, calibration_, depth,
                     [&](const auto& query, auto& neighbours) { cells.find(query, neighbours); });
}

}  // namespace lcmslam
