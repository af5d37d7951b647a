#include <lcmslam/rgbd/feature_depth.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace lcmslam {
namespace {

struct Depth {
  float z = 0, sigma = 0;  // m
};

cv::Point rounded(const Eigen::Vector2d& pixel) {
  return {static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))};
}

// Mean of the 3x3 pixels there; nothing where fewer than five are valid or they are not one surface.
// `three(row, first, points, sigmas)` gives three pixels of a row.
template <class Three>
std::optional<Depth> depth_around(const cv::Size& size, const Three& three, const cv::Point& pixel,
                                  const Eigen::Isometry3f& T_colour_points) {
  constexpr int least = 5;
  constexpr float sigmas = 4, slope = 0.01f;  // pixels beside each other: 3 noises and a grazing surface
  const int column = pixel.x, row = pixel.y;
  if (column < 1 || row < 1 || column + 1 >= size.width || row + 1 >= size.height) return std::nullopt;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float sigma = 0, low = 1e9f, high = 0;
  int count = 0;
  for (int v = row - 1; v <= row + 1; ++v) {
    float points[3 * 3], deviations[3];
    three(v, column - 1, points, deviations);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3f p(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
      if (!std::isfinite(p.z())) continue;
      sum += p;
      sigma += deviations[i];
      low = std::min(low, p.z());
      high = std::max(high, p.z());
      ++count;
    }
  }
  if (count < least) return std::nullopt;
  const auto n = static_cast<float>(count);
  if (!(high - low < sigmas * sigma / n + slope * sum.z() / n)) return std::nullopt;
  return Depth{(T_colour_points * Eigen::Vector3f(sum / n)).z(), sigma / n};
}

template <class Three>
FeatureFrame place(const cv::Size& size, const Three& three, const CameraModel& depth_camera,
                   const Eigen::Isometry3d& T_depth_colour, FeatureFrame features,
                   const Eigen::Isometry3d& T_colour_points) {
  const Eigen::Isometry3f T_points = T_colour_points.cast<float>();
  constexpr int rounds = 3;  // where the ray meets the surface depends on its depth, by the way moved only
  for (Feature& f : features.features) {
    if (f.kind != MeasurementKind::point) continue;
    const Eigen::Vector3d ray((static_cast<double>(f.x) - features.cx) / features.fx,
                              (static_cast<double>(f.y) - features.cy) / features.fy, 1);
    std::optional<Depth> found = Depth{f.point.z(), f.depth_sigma};
    std::optional<cv::Point> last;
    for (int round = 0; round < rounds && found; ++round) {
      const auto seen = depth_camera.project(T_depth_colour * (static_cast<double>(found->z) * ray));
      const auto pixel = seen ? std::optional(rounded(*seen)) : std::nullopt;
      if (pixel && pixel == last) break;  // it would be the same again
      found = pixel ? depth_around(size, three, *pixel, T_points) : std::nullopt;
      last = pixel;
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

}  // namespace

FeatureFrame placed_by(const RegisteredDepth& depth, const CameraModel& depth_camera,
                       const Eigen::Isometry3d& T_depth_colour, FeatureFrame features,
                       const Eigen::Isometry3d& T_colour_points) {
  const auto three = [&](int row, int first, float* points, float* sigmas) {
    std::copy_n(depth.points.ptr<float>(row) + 3 * first, 9, points);
    std::copy_n(depth.sigma.ptr<float>(row) + first, 3, sigmas);
  };
  return place(depth.points.size(), three, depth_camera, T_depth_colour, std::move(features),
               T_colour_points);
}

FeatureFrame placed_by(const DepthPoints& depth, const RgbdFrame& frame,
                       const Eigen::Isometry3d& T_depth_colour, FeatureFrame features,
                       const Eigen::Isometry3d& T_colour_points) {
  const auto three = [&](int row, int first, float* points, float* sigmas) {
    depth.row(frame, row, first, 3, points, sigmas);
  };
  return place(frame.depth.size(), three, depth.calibration().depth, T_depth_colour, std::move(features),
               T_colour_points);
}

}  // namespace lcmslam
