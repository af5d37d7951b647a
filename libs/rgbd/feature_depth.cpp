#include <lcmslam/rgbd/feature_depth.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

struct Depth {
  float z = 0, sigma = 0;  // m
};

// Mean of the 3x3 pixels there; nothing where fewer than five are valid or they are not one surface.
std::optional<Depth> depth_around(const RegisteredDepth& depth, const Eigen::Vector2d& pixel,
                                  const Eigen::Isometry3f& T_colour_points) {
  constexpr int least = 5;
  constexpr float sigmas = 4, slope = 0.01f;  // pixels beside each other: 3 noises and a grazing surface
  const auto column = static_cast<int>(std::lround(pixel.x())),
             row = static_cast<int>(std::lround(pixel.y()));
  if (column < 1 || row < 1 || column + 1 >= depth.points.cols || row + 1 >= depth.points.rows)
    return std::nullopt;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float sigma = 0, low = 1e9f, high = 0;
  int count = 0;
  for (int v = row - 1; v <= row + 1; ++v)
    for (int u = column - 1; u <= column + 1; ++u) {
      const cv::Vec3f& p = depth.points.at<cv::Vec3f>(v, u);
      const float z = p[2];
      if (!std::isfinite(z)) continue;
      sum += Eigen::Vector3f(p[0], p[1], z);
      sigma += depth.sigma.at<float>(v, u);
      low = std::min(low, z);
      high = std::max(high, z);
      ++count;
    }
  if (count < least) return std::nullopt;
  const auto n = static_cast<float>(count);
  if (!(high - low < sigmas * sigma / n + slope * sum.z() / n)) return std::nullopt;
  return Depth{(T_colour_points * Eigen::Vector3f(sum / n)).z(), sigma / n};
}

}  // namespace

FeatureFrame placed_by(const RegisteredDepth& depth, const CameraModel& depth_camera,
                       const Eigen::Isometry3d& T_depth_colour, FeatureFrame features,
                       const Eigen::Isometry3d& T_colour_points) {
  const Eigen::Isometry3f T_points = T_colour_points.cast<float>();
  constexpr int rounds = 3;  // where the ray meets the surface depends on its depth, by the way moved only
  for (Feature& f : features.features) {
    if (f.kind != MeasurementKind::point) continue;
    const Eigen::Vector3d ray((static_cast<double>(f.x) - features.cx) / features.fx,
                              (static_cast<double>(f.y) - features.cy) / features.fy, 1);
    std::optional<Depth> found = Depth{f.point.z(), f.depth_sigma};
    for (int round = 0; round < rounds && found; ++round) {
      const auto pixel = depth_camera.project(T_depth_colour * (static_cast<double>(found->z) * ray));
      found = pixel ? depth_around(depth, *pixel, T_points) : std::nullopt;
    }
    if (found) {
      f.point = (static_cast<double>(found->z) * ray).cast<float>();
      f.depth_sigma = found->sigma;
    } else {
      f.kind = MeasurementKind::bearing;
      f.point.setConstant(std::numeric_limits<float>::quiet_NaN());
      f.depth_sigma = std::numeric_limits<float>::quiet_NaN();
    }
  }
  return features;
}

}  // namespace lcmslam
