#include <lcmslam/imaging/depth_registration.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>

#include <lcmslam/imaging/occlusion.hpp>
#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// What a vectorised loop over a row needs to know.
struct RowGeometry {
  float nearest, farthest;            // mm
  float constant, quadratic, offset;  // of the depth noise
  float R[9], t[3];                   // row-major
};

RowGeometry row_geometry(const RgbdCalibration& calibration, const Eigen::Isometry3d& T) {
  const DepthNoise& noise = calibration.depth_noise;
  RowGeometry g{};
  g.nearest = static_cast<float>(std::max(1.0, std::ceil(calibration.depth_min * 1000)));
  g.farthest = static_cast<float>(std::min(65534.0, std::floor(calibration.depth_max * 1000)));
  g.constant = static_cast<float>(noise.constant);
  g.quadratic = static_cast<float>(noise.quadratic);
  g.offset = static_cast<float>(noise.offset);
  for (int i = 0; i < 9; ++i) g.R[i] = static_cast<float>(T.linear()(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) g.t[i] = static_cast<float>(T.translation()[i]);
  return g;
}

// Valid depths become points z * ray with their standard deviation; the others NaN.
LCMSLAM_VECTORISED(unproject_row,
                   (const std::uint16_t* depth, const float* ray, int columns, const RowGeometry& g,
                    float* point, float* sigma),
                   (depth, ray, columns, g, point, sigma)) {
  for (int u = 0; u < columns; ++u) {
    const auto mm = static_cast<float>(depth[u]);
    const float z = mm >= g.nearest && mm <= g.farthest ? 0.001f * mm : nan_value;
    const float spread = z - g.offset;
    point[3 * u] = z * ray[2 * u];
    point[3 * u + 1] = z * ray[2 * u + 1];
    point[3 * u + 2] = z;
    sigma[u] = g.constant + g.quadratic * spread * spread;
  }
}

LCMSLAM_VECTORISED(move_row, (int columns, const RowGeometry& g, float* point), (columns, g, point)) {
  for (int u = 0; u < columns; ++u) {
    const float x = point[3 * u], y = point[3 * u + 1], z = point[3 * u + 2];
    for (int k = 0; k < 3; ++k)
      point[3 * u + k] = g.R[3 * k] * x + g.R[3 * k + 1] * y + g.R[3 * k + 2] * z + g.t[k];
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
  const DepthNoise& noise = calibration_.depth_noise;
  const bool has_amplitude = noise.amplitude > 0 && !frame.amplitude.empty();
  const bool moved = !T.matrix().isIdentity(0);
  const RowGeometry geometry = row_geometry(calibration_, T);
  for (int v = 0; v < depth.height; ++v) {
    const auto* millimetres = frame.depth.ptr<std::uint16_t>(v);
    auto* point = result.points.ptr<float>(v);
    auto* sigma = result.sigma.ptr<float>(v);
    unproject_row(millimetres, rays_.ptr<float>(v), depth.width, geometry, point, sigma);
    if (noise.amplitude > 0) {
      const auto* amplitude = has_amplitude ? frame.amplitude.ptr<std::uint8_t>(v) : nullptr;
      for (int u = 0; u < depth.width; ++u)  // NaN stays NaN
        if (!std::isnan(sigma[u]))
          sigma[u] = static_cast<float>(
              noise.sigma(0.001 * millimetres[u], has_amplitude ? amplitude[u] / 255.0 : 1.0));
    }
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
  result.pixels = cv::Mat(result.points.size(), CV_32FC2, cv::Scalar::all(nan_value));
  result.aligned = calibration_.depth_registered && T_colour_depth_time.matrix().isIdentity(0);
  if (frame.depth.empty()) return result;
  if (result.aligned) {
    copy_own_pixels(pixel_step, result);
  } else {
    project_points(colour, pixel_step, result);
    hide_occluded(result, {colour.width, colour.height}, pixel_step);
  }
  return result;
}

RegisteredDepth DepthRegistration::for_depth_at_pixels(const RgbdFrame& frame,
                                                       const Eigen::Isometry3d& T_colour_depth_time) const {
  const bool own_pixels = calibration_.depth_registered && T_colour_depth_time.matrix().isIdentity(0);
  if (!own_pixels) return (*this)(frame, T_colour_depth_time);
  RegisteredDepth result = unproject(frame);
  result.aligned = true;
  return result;
}

RegisteredDepth register_depth(const RgbdFrame& frame, const RgbdCalibration& calibration,
                               const Eigen::Isometry3d& T_colour_depth_time) {
  return DepthRegistration(calibration)(frame, T_colour_depth_time);
}

}  // namespace lcmslam
