#include <lcmslam/calibration/corner_fit.hpp>

#include <ceres/tiny_solver.h>
#include <algorithm>
#include <cmath>
#include <vector>

namespace lcmslam {
namespace {

enum Number { corner_x, corner_y, first_angle, second_angle, blur, middle, contrast, numbers };
using Numbers = Eigen::Matrix<double, numbers, 1>;

constexpr std::size_t fewest_inside = 12;
constexpr double usual_blur = 0.7;    // pixels: a pixel's area alone is 0.3
constexpr double farthest = 1.5;      // pixels from where it began
constexpr double least_contrast = 5;  // grey values from the middle to black or white
constexpr double most_unlike = 0.2;   // root mean square of what the model leaves over, by the contrast

struct Pixel {
  double x, y, grey;
};

/// grey = middle + contrast erf(d1 / (sqrt(2) blur)) erf(d2 / (sqrt(2) blur)), d1 and d2 the distances from
/// both edges: four squares out of focus, seen by pixels that have an area. Ceres's TinySolver asks for it.
struct CornerImage {
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = numbers };
  std::vector<Pixel> pixels;

  int NumResiduals() const { return static_cast<int>(pixels.size()); }

  bool operator()(const double* n, double* residuals, double* jacobian) const {
    const double c1 = std::cos(n[first_angle]), s1 = std::sin(n[first_angle]);
    const double c2 = std::cos(n[second_angle]), s2 = std::sin(n[second_angle]);
    const double k = 1 / (std::sqrt(2.0) * n[blur]);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const double dx = pixels[i].x - n[corner_x], dy = pixels[i].y - n[corner_y];
      const double d1 = c1 * dy - s1 * dx, d2 = c2 * dy - s2 * dx;
      const double e1 = std::erf(k * d1), e2 = std::erf(k * d2);
      residuals[i] = n[middle] + n[contrast] * e1 * e2 - pixels[i].grey;
      if (jacobian == nullptr) continue;
      const double slope = n[contrast] * k * 2 / std::sqrt(M_PI);
      const double by_d1 = slope * std::exp(-k * k * d1 * d1) * e2;
      const double by_d2 = slope * std::exp(-k * k * d2 * d2) * e1;
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, numbers>> J(jacobian, NumResiduals(), numbers);
      J.row(static_cast<Eigen::Index>(i)) << by_d1 * s1 + by_d2 * s2, -by_d1 * c1 - by_d2 * c2,
          -by_d1 * (c1 * dx + s1 * dy), -by_d2 * (c2 * dx + s2 * dy), -(by_d1 * d1 + by_d2 * d2) / n[blur], 1,
          e1 * e2;
    }
    return true;
  }
};

std::vector<Pixel> pixels_around(const cv::Mat& grey, const Eigen::Vector2d& middle, double radius) {
  std::vector<Pixel> pixels;
  const auto first = [&](double at) { return std::max(0, static_cast<int>(std::ceil(at - radius))); };
  for (int y = first(middle.y()); y <= middle.y() + radius && y < grey.rows; ++y)
    for (int x = first(middle.x()); x <= middle.x() + radius && x < grey.cols; ++x)
      if ((Eigen::Vector2d(x, y) - middle).norm() <= radius)
        pixels.push_back({static_cast<double>(x), static_cast<double>(y),
                          static_cast<double>(grey.at<std::uint8_t>(y, x))});
  return pixels;
}

/// Middle and contrast that suit the edges, by least squares.
void set_greys(const CornerImage& image, Numbers& n) {
  const auto count = image.NumResiduals();
  Eigen::VectorXd patterns(count), greys(count);
  n[middle] = 0, n[contrast] = 1;
  image(n.data(), patterns.data(), nullptr);  // pattern - grey
  for (Eigen::Index i = 0; i < count; ++i) greys(i) = image.pixels[static_cast<std::size_t>(i)].grey;
  patterns += greys;
  const Eigen::VectorXd centred = patterns.array() - patterns.mean();
  n[contrast] = centred.dot(greys) / std::max(1e-9, centred.squaredNorm());
  n[middle] = greys.mean() - n[contrast] * patterns.mean();
}

}  // namespace

std::optional<Eigen::Vector2d> fit_corner(const cv::Mat& grey, const Eigen::Vector2d& start,
                                          const Eigen::Matrix2d& edges, double radius) {
  const CornerImage image{pixels_around(grey, start, radius)};
  if (image.pixels.size() < fewest_inside) return std::nullopt;
  Numbers n;
  n << start, std::atan2(edges(1, 0), edges(0, 0)), std::atan2(edges(1, 1), edges(0, 1)), usual_blur, 0, 0;
  set_greys(image, n);
  ceres::TinySolver<CornerImage> solver;
  solver.Solve(image, &n);
  const double left_over = std::sqrt(2 * solver.summary.final_cost / image.NumResiduals());
  const Eigen::Vector2d corner = n.head<2>();
  if (!n.allFinite() || (corner - start).norm() > farthest || std::abs(n[contrast]) < least_contrast ||
      left_over > most_unlike * std::abs(n[contrast]))
    return std::nullopt;
  return corner;
}

}  // namespace lcmslam
