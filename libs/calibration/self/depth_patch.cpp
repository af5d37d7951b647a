#include <lcmslam/calibration/self/depth_patch.hpp>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

// rad, from the middle. The widest that is a plane is taken: noise tilts a small patch, and a slope that is
// wrong by chance looks like knowledge of where along the surface a landmark lies.
constexpr double patch_angles[] = {0.064, 0.032, 0.016};
constexpr int most_samples = 18;   // from the middle to the rim
constexpr double fewest = 0.75;    // of the patch's pixels
constexpr double steepest = 3;     // tangent between the surface's normal and the ray
constexpr double farthest = 4;     // sigmas of a pixel from the patch's plane
constexpr double outliers = 0.02;  // of the pixels, that may lie farther off
constexpr double bent = 5;         // sigmas of noise by which a bent surface's middle lies off the plane's

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Of a patch that reaches so many pixels from its middle.
std::optional<residuals::Patch> plane_around(const cv::Mat& inverse_depth, int u, int v, int reach,
                                             const CameraModel& camera, const DepthNoise& noise) {
  if (u < reach || v < reach || u + reach >= inverse_depth.cols || v + reach >= inverse_depth.rows)
    return std::nullopt;
  const int step = (reach + most_samples - 1) / most_samples, rim = reach - reach % step;

  // A plane, and a bent surface, by least squares; coordinates in half sides.
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6 b = Vector6::Zero();
  int count = 0, asked = 0;
  const double unit = 1.0 / reach;
  for (int dv = -rim; dv <= rim; dv += step) {
    const auto* row = inverse_depth.ptr<float>(v + dv);
    for (int du = -rim; du <= rim; du += step) {
      ++asked;
      const auto value = static_cast<double>(row[u + du]);
      if (!(value > 0)) continue;
      const double x = unit * du, y = unit * dv;
      const Vector6 terms = (Vector6() << 1, x, y, x * x, x * y, y * y).finished();
      A.selfadjointView<Eigen::Lower>().rankUpdate(terms);
      b += value * terms;
      ++count;
    }
  }
  if (count < fewest * asked) return std::nullopt;
  A.triangularView<Eigen::StrictlyUpper>() = A.transpose();
  const Eigen::Vector3d fit = A.topLeftCorner<3, 3>().ldlt().solve(b.head<3>());
  const double middle = rim > 1 ? A.ldlt().solve(b)(0) : fit(0);  // things bulge: a plane lies behind them
  if (!(fit(0) > 1e-3 && middle > 1e-3)) return std::nullopt;

  const double z = 1 / fit(0);
  const double sigma = noise.sigma(z), inverse_sigma = sigma * fit(0) * fit(0);
  // Of a plane n x = d: inverse depth = (n_x x + n_y y + n_z) / d, its gradient by x and y over the value.
  const double slope = unit * std::hypot(fit(1) * camera.fx, fit(2) * camera.fy) * z;
  if (slope > steepest) return std::nullopt;
  // Of a full square the middles' difference has 1.6 sigma / sqrt(count).
  if (std::abs(middle - fit(0)) > bent * 1.6 * inverse_sigma / std::sqrt(count)) return std::nullopt;
  int far = 0;
  for (int dv = -rim; dv <= rim; dv += step) {
    const auto* row = inverse_depth.ptr<float>(v + dv);
    for (int du = -rim; du <= rim; du += step) {
      const auto value = static_cast<double>(row[u + du]);
      const double off = value - fit.dot(Eigen::Vector3d(1, unit * du, unit * dv));
      far += value > 0 && std::abs(off) > farthest * inverse_sigma ? 1 : 0;
    }
  }
  if (far > outliers * count) return std::nullopt;
  residuals::Patch patch;
  patch.u = u, patch.v = v;
  patch.inverse = middle, patch.along_u = unit * fit(1), patch.along_v = unit * fit(2);
  patch.sigma = sigma;
  return patch;
}

}  // namespace

std::optional<residuals::Patch> depth_patch(const cv::Mat& inverse_depth, const Eigen::Vector2d& pixel,
                                            const CameraModel& camera, const DepthNoise& noise) {
  if (!pixel.allFinite() || std::abs(pixel.x()) > 1e5 || std::abs(pixel.y()) > 1e5) return std::nullopt;
  const auto u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  for (const double angle : patch_angles)
    if (const auto patch =
            plane_around(inverse_depth, u, v, std::max(1, static_cast<int>(std::lround(angle * camera.fx))),
                         camera, noise))
      return patch;
  return std::nullopt;
}

}  // namespace lcmslam
