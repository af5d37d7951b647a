#include "imaging/registration.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "imaging/occlusion.hpp"

namespace lcmslam {
namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// Valid depths become points T * (z * ray), with their standard deviation; the others NaN.
void unproject(const RgbdFrame& frame, const RgbdCalibration& calibration, const cv::Mat_<cv::Vec2f>& rays,
               const Eigen::Isometry3d& T, RegisteredDepth& result) {
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Eigen::Vector3f t = T.translation().cast<float>();
  const bool moved = !T.matrix().isIdentity(0);
  const int nearest = std::max(1, static_cast<int>(std::ceil(calibration.depth_min * 1000)));
  const int farthest = std::min(65534, static_cast<int>(std::floor(calibration.depth_max * 1000)));
  const bool has_amplitude = calibration.depth_noise.amplitude > 0 && !frame.amplitude.empty();

  for (int v = 0; v < frame.depth.rows; ++v) {
    const auto* depth = frame.depth.ptr<std::uint16_t>(v);
    const auto* amplitude = has_amplitude ? frame.amplitude.ptr<std::uint8_t>(v) : nullptr;
    auto* point = result.points.ptr<cv::Vec3f>(v);
    auto* sigma = result.sigma.ptr<float>(v);
    for (int u = 0; u < frame.depth.cols; ++u) {
      if (depth[u] < nearest || depth[u] > farthest) {
        point[u] = {nan_value, nan_value, nan_value};
        sigma[u] = nan_value;
        continue;
      }
      const float z = 0.001f * static_cast<float>(depth[u]);
      const cv::Vec2f& ray = rays(v, u);
      Eigen::Vector3f p(z * ray[0], z * ray[1], z);
      if (moved) p = R * p + t;
      point[u] = {p.x(), p.y(), p.z()};
      sigma[u] =
          static_cast<float>(calibration.depth_noise.sigma(z, has_amplitude ? amplitude[u] / 255.0 : 1.0));
    }
  }
}

void project_points(const CameraModel& colour, int step, RegisteredDepth& result) {
  for (int v = 0; v < result.points.rows; v += step) {
    const auto* point = result.points.ptr<cv::Vec3f>(v);
    auto* pixel = result.pixels.ptr<cv::Vec2f>(v);
    for (int u = 0; u < result.points.cols; u += step) {
      if (std::isnan(point[u][2])) continue;
      const auto projected = colour.project({point[u][0], point[u][1], point[u][2]});
      if (projected && colour.contains(*projected))
        pixel[u] = {static_cast<float>(projected->x()), static_cast<float>(projected->y())};
    }
  }
}

void copy_own_pixels(int step, RegisteredDepth& result) {
  for (int v = 0; v < result.points.rows; v += step) {
    const auto* point = result.points.ptr<cv::Vec3f>(v);
    auto* pixel = result.pixels.ptr<cv::Vec2f>(v);
    for (int u = 0; u < result.points.cols; u += step)
      if (!std::isnan(point[u][2])) pixel[u] = {static_cast<float>(u), static_cast<float>(v)};
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

RegisteredDepth DepthRegistration::operator()(const RgbdFrame& frame,
                                              const Eigen::Isometry3d& T_colour_depth_time,
                                              int pixel_step) const {
  if (pixel_step < 1) throw std::invalid_argument("pixel_step must be at least 1");
  if (!T_colour_depth_time.matrix().allFinite())
    throw std::invalid_argument("T_colour_depth_time must be finite");
  const CameraModel& depth = calibration_.depth;
  const CameraModel& colour = calibration_.colour;
  const cv::Size size(depth.width, depth.height);
  RegisteredDepth result;
  result.points.create(size, CV_32FC3);
  result.sigma.create(size, CV_32FC1);
  result.pixels = cv::Mat(size, CV_32FC2, cv::Scalar::all(nan_value));
  result.pitch = static_cast<float>(1 / depth.fx);
  result.footprint = static_cast<float>(colour.fx / depth.fx);
  result.aligned = calibration_.depth_registered && T_colour_depth_time.matrix().isIdentity(0);
  if (frame.depth.empty()) {
    result.points.setTo(cv::Scalar::all(nan_value));
    result.sigma.setTo(cv::Scalar::all(nan_value));
    return result;
  }

  check_frame(frame, calibration_);
  unproject(frame, calibration_, rays_, T_colour_depth_time * calibration_.T_colour_depth, result);
  if (result.aligned) {
    copy_own_pixels(pixel_step, result);
  } else {
    project_points(colour, pixel_step, result);
    hide_occluded(result, {colour.width, colour.height}, pixel_step);
  }
  return result;
}

RegisteredDepth register_depth(const RgbdFrame& frame, const RgbdCalibration& calibration,
                               const Eigen::Isometry3d& T_colour_depth_time) {
  return DepthRegistration(calibration)(frame, T_colour_depth_time);
}

}  // namespace lcmslam
