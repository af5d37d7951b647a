#include <lcmslam/imaging/depth_error.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr float table_step = 0.004F;   // m between the table's entries
constexpr double farthest_range = 80;  // m: 65.5 m of depth, to the side
constexpr int largest_depth = 65535;
constexpr float least_factor = 0.5F;  // of a depth by tilt: beyond, nothing is believed of it

void wrong_depth_error(const char* name, double is, const char* right) {
  std::ostringstream message;
  message << "depth_error." << name << " is " << is << ": " << right;
  throw std::invalid_argument(message.str());
}

/// 1 / z less `tilt` (1/mm).
inline float levelled(float measured, float tilt) {
  return measured / std::max(least_factor, 1 - measured * tilt);
}

/// Of a row; 0 stays 0.
LCMSLAM_VECTORISED(level_row, (std::uint16_t* __restrict z, const float* __restrict tilt, int n),
                   (z, tilt, n)) {
  for (int u = 0; u < n; ++u) {
    const float level = levelled(static_cast<float>(z[u]), tilt[u]);
    z[u] = static_cast<std::uint16_t>(std::min(static_cast<int>(level + 0.5F), largest_depth));
  }
}

}  // namespace

double DepthError::at(double range) const {
  return offset + scale * range + wiggle * std::sin(2 * M_PI * range / period + phase);
}

// The error is small and smooth (check()): the fixed point is there after a few steps.
double DepthError::corrected(double measured) const {
  double range = measured;
  for (int i = 0; i < 20; ++i) range = measured - at(range);
  return range;
}

void DepthError::check() const {
  if (!(std::abs(offset) <= 1)) wrong_depth_error("offset", offset, "must be -1 to 1 m");
  if (!(std::abs(scale) <= 0.2)) wrong_depth_error("scale", scale, "must be -0.2 to 0.2");
  if (!(period >= 0.05 && period <= 100)) wrong_depth_error("period", period, "must be 0.05 to 100 m");
  if (!(std::abs(phase) <= 100)) wrong_depth_error("phase", phase, "must be an angle in radians");
  // A steeper wiggle would give one measured range to several true ones.
  if (!(std::abs(wiggle) * 2 * M_PI / period <= 0.5))
    wrong_depth_error("wiggle", wiggle, "must be at most a twelfth of its period");
  if (!(std::abs(tilt_x) <= 0.2)) wrong_depth_error("tilt_x", tilt_x, "must be -0.2 to 0.2 1/m");
  if (!(std::abs(tilt_y) <= 0.2)) wrong_depth_error("tilt_y", tilt_y, "must be -0.2 to 0.2 1/m");
}

bool DepthError::operator==(const DepthError& other) const {
  return offset == other.offset && scale == other.scale && wiggle == other.wiggle && period == other.period &&
         phase == other.phase && tilt_x == other.tilt_x && tilt_y == other.tilt_y;
}

DepthCorrector::DepthCorrector(const CameraModel& camera, const DepthError& error)
    : stretch_(camera.height, camera.width, CV_32FC1), tilt_(stretch_.size(), CV_32FC1) {
  std::vector<double> x(static_cast<std::size_t>(camera.width)), y(x.size());
  for (int v = 0; v < camera.height; ++v) {
    ray_row(camera, v, x.data(), y.data());
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray(x[static_cast<std::size_t>(u)], y[static_cast<std::size_t>(u)], 1);
      stretch_.at<float>(v, u) = static_cast<float>(ray.norm());
      tilt_.at<float>(v, u) = static_cast<float>(1e-3 * (error.tilt_x * ray.x() + error.tilt_y * ray.y()));
    }
  }
  if (!error.has_range_error()) return;
  const auto entries = static_cast<std::size_t>(farthest_range / static_cast<double>(table_step)) + 2;
  factors_.reserve(entries);
  factors_.push_back(1);
  for (std::size_t i = 1; i < entries; ++i) {
    const double measured = static_cast<double>(table_step) * static_cast<double>(i);
    factors_.push_back(static_cast<float>(std::max(0.0, error.corrected(measured)) / measured));
  }
}

void DepthCorrector::operator()(cv::Mat& depth) const {
  if (depth.type() != CV_16UC1 || depth.size() != stretch_.size())
    throw std::invalid_argument(
        "a depth image to be corrected must be 16 bit of one channel, of the camera's size");
  const auto last = static_cast<float>(factors_.size()) - 2;
  for (int v = 0; v < depth.rows; ++v) {
    auto* z = depth.ptr<std::uint16_t>(v);
    const auto* stretch = stretch_.ptr<float>(v);
    const auto* tilt = tilt_.ptr<float>(v);
    if (factors_.empty()) {
      level_row(z, tilt, depth.cols);
      continue;
    }
    for (int u = 0; u < depth.cols; ++u) {
      if (z[u] == 0) continue;
      const float level = levelled(static_cast<float>(z[u]), tilt[u]);
      const float at = std::min(0.001F * level * stretch[u] / table_step, last);
      const auto i = static_cast<std::size_t>(at);
      const float factor = factors_[i] + (at - static_cast<float>(i)) * (factors_[i + 1] - factors_[i]);
      const int corrected = static_cast<int>(factor * level + 0.5F);
      z[u] = static_cast<std::uint16_t>(std::min(corrected, largest_depth));
    }
  }
}

}  // namespace lcmslam
