#include <lcmslam/surface/surface_view.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/surface/colour_lookup.hpp>
#include <lcmslam/surface/voxel_blocks.hpp>

namespace lcmslam {
namespace {

constexpr int halved_from = 480;  // columns

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

/// The mean of what belongs to the nearest of four pixels: a mean over an edge would be a place of its own.
std::uint16_t one_of_four(const std::uint16_t* upper, const std::uint16_t* lower) {
  const int depths[] = {upper[0], upper[1], lower[0], lower[1]};
  int nearest = 1 << 16;
  for (const int d : depths)
    if (d > 0) nearest = std::min(nearest, d);
  const int farthest = nearest + nearest / 32;
  int sum = 0, count = 0;
  for (const int d : depths) {
    const bool belongs = d > 0 && d <= farthest;
    sum += belongs ? d : 0;
    count += belongs;
  }
  return static_cast<std::uint16_t>(count > 0 ? (2 * sum + count) / (2 * count) : 0);
}

cv::Mat halved_depth(const cv::Mat& depth) {
  cv::Mat half(depth.rows / 2, depth.cols / 2, CV_16UC1);
  for (int v = 0; v < half.rows; ++v) {
    const auto *upper = depth.ptr<std::uint16_t>(2 * v), *lower = depth.ptr<std::uint16_t>(2 * v + 1);
    auto* row = half.ptr<std::uint16_t>(v);
    for (int u = 0; u < half.cols; ++u) row[u] = one_of_four(upper + 2 * u, lower + 2 * u);
  }
  return half;
}

cv::Mat halved_bytes(const cv::Mat& image) {
  const int channels = image.channels();
  cv::Mat half(image.rows / 2, image.cols / 2, image.type());
  for (int v = 0; v < half.rows; ++v) {
    const auto *upper = image.ptr<std::uint8_t>(2 * v), *lower = image.ptr<std::uint8_t>(2 * v + 1);
    auto* row = half.ptr<std::uint8_t>(v);
    for (int i = 0; i < half.cols * channels; ++i) {
      const int at = 2 * i - i % channels;
      const int sum = upper[at] + upper[at + channels] + lower[at] + lower[at + channels];
      row[i] = static_cast<std::uint8_t>((sum + 2) / 4);
    }
  }
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
  view.planes.resize(pixels);
  view.weight.resize(pixels);
  view.colours.resize(pixels);
  view.depth.resize(pixels);
  const int tile = SurfaceView::tile;
  view.farthest.create((camera.height + tile - 1) / tile, (camera.width + tile - 1) / tile);
  view.farthest.setTo(0);
  return view;
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
  small.amplitude = halve && !frame.amplitude.empty() ? halved_bytes(frame.amplitude) : frame.amplitude;
  const cv::Mat colour =
      halve && full_.depth_registered && !frame.colour.empty() ? halved_bytes(frame.colour) : frame.colour;

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
  const cv::Mat normals = estimate_normals(registered);
  SurfaceView view = blank_view(small_.depth, depth_lens_);
  view.points = registered.points;
  const auto flattest = static_cast<float>(std::cos(settings_.max_incidence));
  const auto best = static_cast<float>(settings_.best_sigma), range = static_cast<float>(settings_.max_range);
  for (int v = 0; v < image.depth.rows; ++v) {
    const auto* point = registered.points.ptr<cv::Vec3f>(v);
    const auto* normal = normals.ptr<cv::Vec3f>(v);
    const auto* sigma = registered.sigma.ptr<float>(v);
    const auto* colour = image.colour.ptr<cv::Vec3b>(v);
    const auto* seen = image.seen.ptr<std::uint8_t>(v);
    auto* farthest = view.farthest.ptr<float>(v / SurfaceView::tile);
    std::size_t i = view.at(v, 0);
    for (int u = 0; u < image.depth.cols; ++u, ++i) {
      const float z = point[u][2];
      if (!(z <= range) || std::isnan(normal[u][0])) continue;
      const float offset = -(normal[u].dot(point[u]));
      const float cosine = offset / std::sqrt(point[u].dot(point[u]));
      if (!(cosine >= flattest)) continue;
      // Across the surface a depth's error counts by the cosine; a slanted look is still the worse one.
      const float certainty = std::min(1.0f, best * best / (sigma[u] * sigma[u]));
      view.planes[i] = {normal[u][0], normal[u][1], normal[u][2], offset};
      view.weight[i] = std::max(1.0f, VoxelBlock::full_look * certainty * cosine);
      view.depth[i] = z;
      farthest[u / SurfaceView::tile] = std::max(farthest[u / SurfaceView::tile], z);
      if (seen[u] == 0) continue;
      view.colours[i] = {colour[u][0], colour[u][1], colour[u][2],
                         static_cast<std::uint8_t>(std::max(1.0f, 16 * cosine * cosine))};
    }
  }
  return view;
}

}  // namespace lcmslam
