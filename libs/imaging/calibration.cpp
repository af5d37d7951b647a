#include <lcmslam/imaging/calibration.hpp>

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace lcmslam {
namespace {

void refuse(const std::string& name, double is, const char* right) {
  std::ostringstream message;
  message << name << " is " << is << ": " << right;
  throw std::invalid_argument(message.str());
}

bool is_rigid(const Eigen::Isometry3d& T) {
  return T.matrix().allFinite() &&
         (T.linear() * T.linear().transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-6 &&
         T.linear().determinant() > 0;
}

}  // namespace

double DepthNoise::sigma(double z, double relative_amplitude) const {
  const double range = z - offset;
  double result = constant + quadratic * range * range;
  if (amplitude > 0) result += amplitude * z * z / std::sqrt(std::max(relative_amplitude, 1.0 / 255));
  return result;
}

void RgbdCalibration::check() const {
  colour.check("colour");
  depth.check("depth");
  if (depth_registered && (depth.width != colour.width || depth.height != colour.height))
    refuse("depth.width", depth.width,
           "a depth image that is registered to the colour image (depth_registered) must have its size");
  if (!is_rigid(T_colour_depth)) throw std::invalid_argument("colour_depth is not a rigid transform");
  if (!is_rigid(T_robot_camera)) throw std::invalid_argument("mount is not a rigid transform");
  if (!(std::abs(depth_clock_offset) <= 10))
    refuse("depth_clock_offset", depth_clock_offset, "must be -10 to 10 s");
  if (!(rolling_shutter >= 0 && rolling_shutter <= 0.1))
    refuse("rolling_shutter", rolling_shutter, "must be 0 to 0.1 s");
  depth_error.check();
  if (!(depth_noise.constant > 0)) refuse("depth_noise.constant", depth_noise.constant, "must be above 0 m");
  if (!(depth_noise.quadratic >= 0)) refuse("depth_noise.quadratic", depth_noise.quadratic, "must be >= 0");
  if (!(depth_noise.amplitude >= 0)) refuse("depth_noise.amplitude", depth_noise.amplitude, "must be >= 0");
  if (!std::isfinite(depth_noise.offset)) refuse("depth_noise.offset", depth_noise.offset, "must be finite");
  if (!(depth_min >= 0)) refuse("depth_min", depth_min, "must be >= 0 m");
  if (!(depth_max > depth_min && depth_max <= 65.535))
    refuse("depth_max", depth_max, "must be above depth_min and at most 65.535 m");
  if (!(pixel_sigma > 0)) refuse("pixel_sigma", pixel_sigma, "must be above 0 pixels");
}

}  // namespace lcmslam
