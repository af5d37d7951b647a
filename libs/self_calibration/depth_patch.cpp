#include <lcmslam/self_calibration/depth_patch.hpp>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

constexpr double patch_angle = 0.0055;  // rad, from the middle: 3 pixels of a VGA camera
constexpr double fewest = 0.75;         // of the patch's pixels
constexpr double steepest = 1.2;        // tangent between the surface's normal and the ray
constexpr double farthest = 4;          // sigmas of a pixel from the patch's plane

}  // namespace

std::optional<residuals::Patch> depth_patch(const cv::Mat& inverse_depth, const Eigen::Vector2d& pixel,
                                            const CameraModel& camera, const DepthNoise& noise) {
  const int reach = std::max(1, static_cast<int>(std::lround(patch_angle * camera.fx)));
  if (!pixel.allFinite() || std::abs(pixel.x()) > 1e5 || std::abs(pixel.y()) > 1e5) return std::nullopt;
  const auto u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  if (u < reach || v < reach || u + reach >= inverse_depth.cols || v + reach >= inverse_depth.rows)
    return std::nullopt;

  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  int count = 0;
  for (int dv = -reach; dv <= reach; ++dv) {
    const auto* row = inverse_depth.ptr<float>(v + dv);
    for (int du = -reach; du <= reach; ++du) {
      const auto value = static_cast<double>(row[u + du]);
      if (!(value > 0)) continue;
      const Eigen::Vector3d x(1, du, dv);
      A += x * x.transpose();
      b += value * x;
      ++count;
    }
  }
  const int side = 2 * reach + 1;
  if (count < fewest * side * side) return std::nullopt;
  const Eigen::Vector3d fit = A.ldlt().solve(b);
  if (!(fit(0) > 1e-3)) return std::nullopt;

  const double z = 1 / fit(0);
  const double sigma = noise.sigma(z), inverse_sigma = sigma * fit(0) * fit(0);
  // Of a plane n x = d: inverse depth = (n_x x + n_y y + n_z) / d, its gradient by x and y over the value.
  const double slope = std::hypot(fit(1) * camera.fx, fit(2) * camera.fy) * z;
  if (slope > steepest) return std::nullopt;
  for (int dv = -reach; dv <= reach; ++dv) {
    const auto* row = inverse_depth.ptr<float>(v + dv);
    for (int du = -reach; du <= reach; ++du) {
      const auto value = static_cast<double>(row[u + du]);
      if (value > 0 && std::abs(value - fit.dot(Eigen::Vector3d(1, du, dv))) > farthest * inverse_sigma)
        return std::nullopt;
    }
  }
  residuals::Patch patch;
  patch.u = u, patch.v = v;
  patch.inverse = fit(0), patch.along_u = fit(1), patch.along_v = fit(2);
  patch.sigma = sigma;
  return patch;
}

}  // namespace lcmslam
