#include <lcmslam/imaging/depth_registration.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>

#include <lcmslam/imaging/depth_rows.hpp>
#include <lcmslam/imaging/occlusion.hpp>

namespace lcmslam {
namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// Pixels of every step-th row and column, hidden ones included, which go into the buffer.
void project_points(const CameraModel& colour, int step, RegisteredDepth& result, DepthBuffer& buffer) {
  const LensRowGeometry lens = lens_row_geometry(colour);
  const int columns = result.points.cols, kept = (columns + step - 1) / step;
  std::vector<float> u(static_cast<std::size_t>(columns)), v(u), z(u);
  for (int row = 0; row < result.points.rows; row += step) {
    project_row(result.points.ptr<float>(row), columns, lens, u.data(), v.data(), z.data());
    auto* pixel = result.pixels.ptr<cv::Vec2f>(row);
    for (int i = 0; i < kept; ++i) {
      const auto at = static_cast<std::size_t>(i * step), to = static_cast<std::size_t>(i);
      u[to] = u[at], v[to] = v[at], z[to] = z[at];
      pixel[at] = {u[to], v[to]};
    }
    buffer.splat(u.data(), v.data(), z.data(), kept);
  }
}

void copy_own_pixels(int step, RegisteredDepth& result) {
  for (int v = 0; v < result.points.rows; v += step) {
    const auto* point = result.points.ptr<cv::Vec3f>(v);
    auto* pixel = result.pixels.ptr<cv::Vec2f>(v);
    for (int u = 0; u < result.points.cols; u += step)
      pixel[u] = std::isnan(point[u][2]) ? cv::Vec2f(nan_value, nan_value)
                                         : cv::Vec2f(static_cast<float>(u), static_cast<float>(v));
  }
}

}  // namespace

DepthRegistration::DepthRegistration(RgbdCalibration calibration) : calibration_(std::move(calibration)) {
  if (calibration_.depth_registered) {
    calibration_.depth = calibration_.colour;
    calibration_.T_colour_depth.setIdentity();
  }
  calibration_.check();
  rays_ = ray_table(calibration_.depth);
  tiles_ = DepthTiles(calibration_.colour, rays_);
}

void check_frame(const RgbdFrame& frame, const RgbdCalibration& calibration) {
  const CameraModel& colour = calibration.colour;
  const CameraModel& depth = calibration.depth;
  if (!frame.colour.empty() && (frame.colour.cols != colour.width || frame.colour.rows != colour.height))
    throw std::invalid_argument("the colour image is " + size_text(frame.colour.cols, frame.colour.rows) +
                                ", by its calibration it must be " + size_text(colour.width, colour.height));
  if (frame.depth.empty()) return;
  if (frame.depth.type() != CV_16UC1 || frame.depth.cols != depth.width || frame.depth.rows != depth.height)
    throw std::invalid_argument("the depth image is " + size_text(frame.depth.cols, frame.depth.rows) +
                                ", by its calibration it must be " + size_text(depth.width, depth.height) +
                                " with 16 bits");
  if (!frame.amplitude.empty() &&
      (frame.amplitude.type() != CV_8UC1 || frame.amplitude.size() != frame.depth.size()))
    throw std::invalid_argument("the amplitude image must have the depth image's size and 8 bits");
}

RegisteredDepth DepthRegistration::unproject(const RgbdFrame& frame) const {
  return unproject(frame, calibration_.T_colour_depth);
}

RegisteredDepth DepthRegistration::unproject(const RgbdFrame& frame, const Eigen::Isometry3d& T) const {
  const CameraModel& depth = calibration_.depth;
  RegisteredDepth result;
  result.points.create(depth.height, depth.width, CV_32FC3);
  result.sigma.create(depth.height, depth.width, CV_32FC1);
  result.pitch = static_cast<float>(1 / depth.fx);
  result.footprint = static_cast<float>(calibration_.colour.fx / depth.fx);
  if (frame.depth.empty()) {
    result.points.setTo(cv::Scalar::all(nan_value));
    result.sigma.setTo(cv::Scalar::all(nan_value));
    return result;
  }
  check_frame(frame, calibration_);
  const bool moved = !T.matrix().isIdentity(0);
  const DepthRowGeometry geometry = depth_row_geometry(calibration_, T);
  for (int v = 0; v < depth.height; ++v) {
    auto* point = result.points.ptr<float>(v);
    unproject_row(frame.depth.ptr<std::uint16_t>(v),
                  frame.amplitude.empty() ? nullptr : frame.amplitude.ptr<std::uint8_t>(v),
                  rays_.ptr<float>(v), depth.width, geometry, point, result.sigma.ptr<float>(v));
    if (moved) move_row(depth.width, geometry, point);
  }
  return result;
}

RegisteredDepth DepthRegistration::operator()(const RgbdFrame& frame,
                                              const Eigen::Isometry3d& T_colour_depth_time,
                                              int pixel_step) const {
  if (pixel_step < 1) throw std::invalid_argument("pixel_step must be at least 1");
  if (!T_colour_depth_time.matrix().allFinite())
    throw std::invalid_argument("T_colour_depth_time must be finite");
  const CameraModel& colour = calibration_.colour;
  RegisteredDepth result = unproject(frame, T_colour_depth_time * calibration_.T_colour_depth);
  result.pixels.create(result.points.size(), CV_32FC2);
  result.aligned = calibration_.depth_registered && T_colour_depth_time.matrix().isIdentity(0);
  if (frame.depth.empty() || pixel_step > 1) result.pixels.setTo(cv::Scalar::all(nan_value));
  if (frame.depth.empty()) return result;
  if (result.aligned) {
    copy_own_pixels(pixel_step, result);
  } else {
    DepthBuffer buffer({colour.width, colour.height}, static_cast<float>(pixel_step) * result.footprint);
    project_points(colour, pixel_step, result, buffer);
    buffer.close();
    hide_occluded(result, buffer, pixel_step);
  }
  return result;
}

RegisteredDepth register_depth(const RgbdFrame& frame, const RgbdCalibration& calibration,
                               const Eigen::Isometry3d& T_colour_depth_time) {
  return DepthRegistration(calibration)(frame, T_colour_depth_time);
}

}  // namespace lcmslam
