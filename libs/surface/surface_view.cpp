#include <lcmslam/surface/surface_view.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/surface/colour_lookup.hpp>
#include <lcmslam/surface/halved_image.hpp>
#include <lcmslam/surface/voxel_blocks.hpp>

namespace lcmslam {
namespace {

constexpr int halved_from = 480;        // columns
constexpr float edge_share = 1 / 4.0f;  // of a look whose pixel has no normal
constexpr int shared_from = 240;        // columns; of smaller images each pixel gets a normal of its own

/// As if each two by two pixels of large images were one.
RgbdCalibration small_calibration(RgbdCalibration calibration) {
  const CameraModel& depth = calibration.depth;
  if (depth.width < halved_from || depth.width % 2 != 0 || depth.height % 2 != 0) return calibration;
  calibration.depth = depth.scaled(0.5);
  if (calibration.depth_registered) calibration.colour = calibration.colour.scaled(0.5);
  return calibration;
}

/// Points stay in the depth camera's frame.
RgbdCalibration depth_alone(RgbdCalibration calibration) {
  calibration.T_colour_depth.setIdentity();
  return calibration;
}

cv::Mat halved_mean(const cv::Mat& image) {
  cv::Mat half;
  cv::resize(image, half, {image.cols / 2, image.rows / 2}, 0, 0, cv::INTER_AREA);
  return half;
}

/// Points of rows of pixels into another frame.
void move_points(const Eigen::Isometry3d& T, cv::Mat& points) {
  const Eigen::Isometry3f move = T.cast<float>();
  for (int v = 0; v < points.rows; ++v) {
    Eigen::Map<Eigen::Matrix3Xf> row(points.ptr<float>(v), 3, points.cols);
    row = (move.linear() * row).colwise() + move.translation();
  }
}

SurfaceView blank_view(const CameraModel& camera, const Lens& lens) {
  SurfaceView view{camera, lens, {}, {}, {}, {}, {}, {}};
  const std::size_t pixels = view.at(camera.height, 0) + 1;
  view.pixels.resize(pixels);
  view.depth.resize(pixels);
  const int tile = SurfaceView::tile;
  const cv::Size tiles((camera.width + tile - 1) / tile, (camera.height + tile - 1) / tile);
  view.farthest = cv::Mat_<float>(tiles, 0.0f);
  view.flattest = cv::Mat_<float>(tiles, 0.0f);
  return view;
}

/// The normals of every second row and column, for their neighbours as well as long as these lie on the same
/// plane. NaN elsewhere.
cv::Mat shared_normals(const RegisteredDepth& registered) {
  constexpr float noise = 4.2f;  // three standard deviations of a difference
  const cv::Mat few = estimate_normals(registered, 2);
  const float unknown = std::numeric_limits<float>::quiet_NaN();
  cv::Mat normals(registered.points.size(), CV_32FC3);
  for (int v = 0; v < normals.rows; ++v) {
    const auto *point = registered.points.ptr<cv::Vec3f>(v), *even = registered.points.ptr<cv::Vec3f>(v & ~1),
               *normal = few.ptr<cv::Vec3f>(v / 2);
    const auto* sigma = registered.sigma.ptr<float>(v);
    auto* shared = normals.ptr<cv::Vec3f>(v);
    for (int u = 0; u < normals.cols; ++u) {
      const float* n = normal[u / 2].val;
      const float *p = point[u].val, *q = even[u & ~1].val;
      const float off = n[0] * (p[0] - q[0]) + n[1] * (p[1] - q[1]) + n[2] * (p[2] - q[2]);
      const bool same = std::abs(off) <= noise * sigma[u];  // NaN: not
      for (int k = 0; k < 3; ++k) shared[u][k] = same ? n[k] : unknown;
    }
  }
  return normals;
}

struct Limits {
  float range, cosine;  // m, least
  float best_variance;  // m^2
};

/// Of a row's pixels.
struct PixelRow {
  explicit PixelRow(int columns) : offset(columns), weight(columns) {}
  cv::AutoBuffer<float> offset, weight;  // weight 0: not to be used
};

// At the edges of things, where no plane fits, a pixel's normal points at the camera: such looks count
// little, but without them whatever is thin would have gaps.
LCMSLAM_VECTORISED(weigh_pixels,
                   (const float* point, float* __restrict normal, const float* sigma, int columns,
                    const Limits& limits, float* __restrict offset, float* __restrict weight),
                   (point, normal, sigma, columns, limits, offset, weight)) {
  const Limits limit = limits;
  for (int u = 0; u < columns; ++u) {
    const float x = point[3 * u], y = point[3 * u + 1], z = point[3 * u + 2];
    const float to_camera = -1 / std::sqrt(x * x + y * y + z * z);
    const bool at_edge = !(normal[3 * u] <= 1);  // NaN
    const float nx = at_edge ? to_camera * x : normal[3 * u],
                ny = at_edge ? to_camera * y : normal[3 * u + 1],
                nz = at_edge ? to_camera * z : normal[3 * u + 2];
    normal[3 * u] = nx;
    normal[3 * u + 1] = ny;
    normal[3 * u + 2] = nz;
    const float distance = -(nx * x + ny * y + nz * z);
    const float cosine = -distance * to_camera;
    // Across the surface a depth's error counts by the cosine; a slanted look is still the worse one.
    const float share = limit.best_variance / (sigma[u] * sigma[u]);
    const float look =
        VoxelBlock::full_look * (at_edge ? edge_share : 1.0f) * (share < 1 ? share : 1.0f) * cosine;
    const bool good = (z <= limit.range) & (cosine >= limit.cosine);  // NaN: not
    offset[u] = distance;
    weight[u] = good ? (look > 1 ? look : 1.0f) : 0.0f;
  }
}

}  // namespace

SurfaceViewMaker::SurfaceViewMaker(const RgbdCalibration& calibration, const SurfaceSettings& settings)
    : full_(DepthRegistration(calibration).calibration()),
      small_(small_calibration(full_)),
      to_depth_(depth_alone(small_)),
      colour_lens_(small_.colour),
      depth_lens_(small_.depth),
      settings_(settings) {}

SurfaceImage SurfaceViewMaker::image(const RgbdFrame& frame,
                                     const Eigen::Isometry3d& T_colour_depth_time) const {
  check_frame(frame, full_);
  if (frame.depth.empty()) throw std::invalid_argument("the frame has no depth image");
  const bool halve = small_.depth.width < full_.depth.width;
  RgbdFrame small;
  small.depth = halve ? halved_depth(frame.depth) : frame.depth;
  small.amplitude = halve && !frame.amplitude.empty() ? halved_mean(frame.amplitude) : frame.amplitude;
  const cv::Mat colour =
      halve && full_.depth_registered && !frame.colour.empty() ? halved_mean(frame.colour) : frame.colour;

  SurfaceImage image;
  image.depth = small.depth;
  image.amplitude = small.amplitude;
  image.T_camera_depth = T_colour_depth_time * small_.T_colour_depth;
  image.colour = cv::Mat(small.depth.size(), CV_8UC3, cv::Scalar::all(0));
  image.seen = cv::Mat(small.depth.size(), CV_8UC1, cv::Scalar(0));
  if (colour.empty()) return image;
  if (full_.depth_registered && T_colour_depth_time.matrix().isIdentity(0)) {
    image.colour = colour.clone();
    image.seen.setTo(255);
    return image;
  }
  cv::Mat points = to_depth_.unproject(small).points;
  move_points(image.T_camera_depth, points);
  const auto footprint = static_cast<float>(small_.colour.fx / small_.depth.fx);
  look_up_colours(points, colour, colour_lens_, footprint, image.colour, image.seen);
  return image;
}

SurfaceView SurfaceViewMaker::view(const SurfaceImage& image) const {
  RgbdFrame frame;
  frame.depth = image.depth;
  frame.amplitude = image.amplitude;
  const RegisteredDepth registered = to_depth_.unproject(frame);
  const bool is_fine = image.depth.cols >= shared_from;
  cv::Mat normals = is_fine ? shared_normals(registered) : estimate_normals(registered);
  SurfaceView view = blank_view(small_.depth, depth_lens_);
  view.points = registered.points;
  view.normals = normals;
  const Limits limits{static_cast<float>(settings_.max_range),
                      static_cast<float>(std::cos(settings_.max_incidence)),
                      static_cast<float>(settings_.best_sigma * settings_.best_sigma)};
  PixelRow row(image.depth.cols);
  for (int v = 0; v < image.depth.rows; ++v) {
    const auto* point = registered.points.ptr<cv::Vec3f>(v);
    auto* normal = normals.ptr<cv::Vec3f>(v);
    const auto* colour = image.colour.ptr<cv::Vec3b>(v);
    const auto* seen = image.seen.ptr<std::uint8_t>(v);
    weigh_pixels(point->val, normal->val, registered.sigma.ptr<float>(v), image.depth.cols, limits,
                 row.offset.data(), row.weight.data());
    float *farthest = view.farthest[v / SurfaceView::tile], *flattest = view.flattest[v / SurfaceView::tile];
    SurfacePixel* pixel = view.pixels.data() + view.at(v, 0);
    float* depth = view.depth.data() + view.at(v, 0);
    for (std::size_t u = 0; u < row.weight.size(); ++u) {
      if (row.weight[u] <= 0) continue;
      const float z = point[u][2], offset = row.offset[u];
      const int look = static_cast<int>(row.weight[u] + 0.5f) | (seen[u] > 0 ? SurfacePixel::coloured : 0);
      pixel[u] = {{normal[u][0], normal[u][1], normal[u][2], offset},
                  {colour[u][0], colour[u][1], colour[u][2]},
                  static_cast<std::uint8_t>(look)};
      depth[u] = z;
      const std::size_t tile = u / SurfaceView::tile;
      farthest[tile] = std::max(farthest[tile], z);
      flattest[tile] = std::max(flattest[tile], z / offset);
    }
  }
  return view;
}

}  // namespace lcmslam
