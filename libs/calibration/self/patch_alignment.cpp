#include <lcmslam/calibration/self/patch_alignment.hpp>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <vector>

namespace lcmslam {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Bilinear; NaN outside.
double grey_at(const cv::Mat& image, double x, double y) {
  const double left = std::floor(x), top = std::floor(y);
  if (!(left >= 0 && top >= 0 && left + 1 < image.cols && top + 1 < image.rows)) return std::nan("");
  const double dx = x - left, dy = y - top;
  const auto* upper = image.ptr<std::uint8_t>(static_cast<int>(top)) + static_cast<int>(left);
  const auto* lower = upper + image.step;
  return (1 - dy) * ((1 - dx) * upper[0] + dx * upper[1]) + dy * ((1 - dx) * lower[0] + dx * lower[1]);
}

/// Grey values less their mean; false at the image's rim.
struct Greys {
  std::vector<double> values;
  double contrast = 0;  // their length

  bool take(const cv::Mat& image, const PatchWarp& warp, int radius) {
    values.clear();
    double sum = 0;
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x) {
        const Eigen::Vector2d p = warp(x, y);
        values.push_back(grey_at(image, p.x(), p.y()));
        sum += values.back();
      }
    if (!std::isfinite(sum)) return false;
    const double mean = sum / static_cast<double>(values.size());
    double squares = 0;
    for (double& value : values) value -= mean, squares += value * value;
    contrast = std::sqrt(squares);
    return true;
  }
};

}  // namespace

// Baker and Matthews 2004, "Lucas-Kanade 20 years on": the inverse compositional algorithm, with each patch's
// own brightness and contrast taken out.
std::optional<PatchWarp> align_patch(const cv::Mat& reference, const Eigen::Vector2d& at, int radius,
                                     const cv::Mat& image, const PatchWarp& start,
                                     const PatchAlignmentSettings& settings) {
  PatchWarp here;
  here.t = at;
  Greys wanted, seen;
  if (!wanted.take(reference, here, radius)) return std::nullopt;
  const auto count = static_cast<double>(wanted.values.size());
  if (wanted.contrast < settings.least_contrast * std::sqrt(count)) return std::nullopt;

  std::vector<Vector6> steepest;
  Matrix6 H = Matrix6::Zero();
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) {
      const double u = at.x() + x, v = at.y() + y;
      const double gx = 0.5 * (grey_at(reference, u + 1, v) - grey_at(reference, u - 1, v)),
                   gy = 0.5 * (grey_at(reference, u, v + 1) - grey_at(reference, u, v - 1));
      steepest.push_back((Vector6() << gx * x, gx * y, gy * x, gy * y, gx, gy).finished());
      H += steepest.back() * steepest.back().transpose();
    }
  if (!H.allFinite()) return std::nullopt;
  const Eigen::LDLT<Matrix6> solver(H);

  PatchWarp warp = start;
  double likeness = 0;
  for (int i = 0; i < settings.iterations; ++i) {
    if (!seen.take(image, warp, radius) || !(seen.contrast > 0)) return std::nullopt;
    const double gain = wanted.contrast / seen.contrast;
    Vector6 b = Vector6::Zero();
    likeness = 0;
    for (std::size_t k = 0; k < seen.values.size(); ++k) {
      b += (gain * seen.values[k] - wanted.values[k]) * steepest[k];
      likeness += seen.values[k] * wanted.values[k];
    }
    likeness /= seen.contrast * wanted.contrast;
    const Vector6 step = solver.solve(b);
    if (!step.allFinite()) return std::nullopt;
    Eigen::Matrix2d A;
    A << 1 + step(0), step(1), step(2), 1 + step(3);
    if (!(A.determinant() > 0.1)) return std::nullopt;
    warp.A = warp.A * A.inverse();
    warp.t -= warp.A * step.tail<2>();
    if ((warp.t - start.t).norm() > settings.farthest) return std::nullopt;
    if ((step.head<4>() * radius).norm() + step.tail<2>().norm() < settings.converged)
      return likeness > settings.least_likeness ? std::optional(warp) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace lcmslam
