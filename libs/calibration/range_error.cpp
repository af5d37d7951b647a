#include <lcmslam/calibration/range_error.hpp>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>
#include <stdexcept>

namespace lcmslam {
namespace {

constexpr double bin_width = 0.02;       // m
constexpr double rim = 2;                // pixels
constexpr double shortest_period = 0.5;  // m
constexpr std::size_t fewest_pixels = 20, fewest_samples = 10;

double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The median of a bin, and how sure it is: 1.2533 sigma / sqrt(n), sigma from the median of the deviations.
RangeSample sample_of(double range, double shared_sigma, std::vector<double>& errors) {
  RangeSample sample;
  sample.range = range;
  sample.error = median_of(errors);
  for (double& e : errors) e = std::abs(e - sample.error);
  const double sigma = std::max(1.4826 * median_of(errors), 3e-4);
  sample.sigma = std::hypot(1.2533 * sigma / std::sqrt(static_cast<double>(errors.size())), shared_sigma);
  return sample;
}

/// Weighted least squares with the wiggle's period fixed: offset + scale r + a sin + b cos.
class LinearFit {
 public:
  LinearFit(const std::vector<RangeSample>& samples, double period, double scale_sigma) {
    const int unknowns = period > 0 ? 4 : 2;
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(unknowns, unknowns);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(unknowns);
    A(1, 1) = 1 / (scale_sigma * scale_sigma);
    for (const RangeSample& s : samples) {
      Eigen::VectorXd row = Eigen::VectorXd::Ones(unknowns);
      row[1] = s.range;
      if (period > 0)
        row.tail<2>() << std::sin(2 * M_PI * s.range / period), std::cos(2 * M_PI * s.range / period);
      const double weight = 1 / (s.sigma * s.sigma);
      A += weight * row * row.transpose();
      b += weight * s.error * row;
      squares_ += weight * s.error * s.error;
    }
    const Eigen::LDLT<Eigen::MatrixXd> solver(A);
    solution = solver.solve(b);
    covariance = solver.solve(Eigen::MatrixXd::Identity(unknowns, unknowns));
    squares_ -= b.dot(solution);
    if (!(solver.vectorD().minCoeff() > 1e-9 * solver.vectorD().maxCoeff())) squares_ = 1e300;
  }
  double squares() const { return squares_; }
  Eigen::VectorXd solution;
  Eigen::MatrixXd covariance;

 private:
  double squares_ = 0;  // what is left, in units of variance
};

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

DepthError error_of(const Vector5d& p) {
  return {p[0], p[1], p[2], p[3], p[4]};
}

/// Derivatives of DepthError::at() by its five values.
Vector5d derivatives(const Vector5d& p, double r) {
  const double angle = 2 * M_PI * r / p[3] + p[4], c = p[2] * std::cos(angle);
  return (Vector5d() << 1, r, std::sin(angle), -c * 2 * M_PI * r / (p[3] * p[3]), c).finished();
}

/// Gauss-Newton from a start that is within a fraction of a period.
Matrix5d refine_error(const std::vector<RangeSample>& samples, double scale_sigma, Vector5d& p) {
  Matrix5d A;
  for (int iteration = 0; iteration < 30; ++iteration) {
    A.setZero();
    A(1, 1) = 1 / (scale_sigma * scale_sigma);
    Vector5d b = Vector5d::Zero();
    b[1] = -p[1] * A(1, 1);
    for (const RangeSample& s : samples) {
      const Vector5d row = derivatives(p, s.range);
      A += row * row.transpose() / (s.sigma * s.sigma);
      b += row * (s.error - error_of(p).at(s.range)) / (s.sigma * s.sigma);
    }
    p += A.ldlt().solve(b);
  }
  return A.inverse();
}

double weighted_squares(const std::vector<RangeSample>& samples, const DepthError& error) {
  double sum = 0;
  for (const RangeSample& s : samples) sum += std::pow((s.error - error.at(s.range)) / s.sigma, 2);
  return sum;
}

double rms(const std::vector<RangeSample>& samples, const DepthError& error) {
  double sum = 0;
  for (const RangeSample& s : samples) sum += std::pow(s.error - error.at(s.range), 2);
  return std::sqrt(sum / static_cast<double>(samples.size()));
}

std::string metres(double value) {
  std::ostringstream stream;
  stream << std::fixed << std::setprecision(2) << value << " m";
  return stream.str();
}

/// False where it is not sure that it is one: its period is hardly known, or it is no larger than its error.
bool take_wiggle(const std::vector<RangeSample>& samples, double period, double scale_sigma, double span,
                 RangeErrorFit& fit) {
  const LinearFit start(samples, period, scale_sigma);
  Vector5d p;
  p << start.solution[0], start.solution[1], start.solution.tail<2>().norm(), period,
      std::atan2(start.solution[3], start.solution[2]);
  const Matrix5d covariance = refine_error(samples, scale_sigma, p);
  const bool sure = p[2] > 3 * std::sqrt(covariance(2, 2)) && p[3] > 0 &&
                    std::sqrt(covariance(3, 3)) < 0.15 * p[3] && p[3] < 1.3 * span &&
                    std::abs(p[3] / period - 1) < 0.3;
  if (!sure) return false;
  fit.error = error_of(p);
  fit.covariance = covariance;
  return true;
}

}  // namespace

double board_distance_sigma(const CameraModel& camera, const Board& board, double distance) {
  constexpr double corner_bias = 0.1;  // pixels
  return std::max(5e-4, corner_bias * distance * distance / (camera.fx * board.width()));
}

std::vector<RangeSample> board_ranges(const cv::Mat& depth, const CameraModel& camera, const Board& board,
                                      const Eigen::Isometry3d& T_camera_board, double pose_sigma) {
  if (depth.type() != CV_16UC1 || depth.cols != camera.width || depth.rows != camera.height)
    throw std::invalid_argument(
        "a board's ranges need a depth image of the camera's size, 16 bit of one channel");
  const Eigen::Vector3d normal = T_camera_board.linear().col(2), origin = T_camera_board.translation();
  const Eigen::Isometry3d T_board_camera = T_camera_board.inverse();
  std::map<int, std::pair<double, std::vector<double>>> bins;  // sum of ranges, errors
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      if (depth.at<std::uint16_t>(v, u) == 0) continue;
      const Eigen::Vector3d ray = camera.ray({u, v});
      const double z = normal.dot(origin) / normal.dot(ray);
      if (!(z > 0)) continue;
      const Eigen::Vector3d p = T_board_camera * (z * ray);
      const double margin = rim * z / std::min(camera.fx, camera.fy) / std::max(0.2, std::abs(normal.z()));
      if (p.x() < margin || p.y() < margin || p.x() > board.width() - margin ||
          p.y() > board.height() - margin)
        continue;
      const double range = z * ray.norm(), measured = 1e-3 * depth.at<std::uint16_t>(v, u) * ray.norm();
      if (std::abs(measured - range) > gross_range_error) continue;
      auto& [sum, errors] = bins[static_cast<int>(range / bin_width)];
      sum += range;
      errors.push_back(measured - range);
    }
  std::vector<RangeSample> samples;
  const auto is_sample = [](const auto& bin) { return bin.second.second.size() >= fewest_pixels; };
  // What is wrong with the distance is in each of them, and fits take them for independent.
  const double shared_sigma =
      pose_sigma * std::sqrt(static_cast<double>(std::count_if(bins.begin(), bins.end(), is_sample)));
  for (auto& bin : bins) {
    auto& [sum, errors] = bin.second;
    if (is_sample(bin))
      samples.push_back(sample_of(sum / static_cast<double>(errors.size()), shared_sigma, errors));
  }
  return samples;
}

RangeErrorFit fit_range_error(const std::vector<RangeSample>& samples,
                              const RangeErrorFitSettings& settings) {
  if (samples.size() < fewest_samples)
    throw std::invalid_argument("the depth images show the board in " + std::to_string(samples.size()) +
                                " ranges within " + metres(gross_range_error) +
                                " of where it is; at least ten are needed: hold it at more distances, or, "
                                "where ranges are further off "
                                "than that, give by hand what they err by (depth_error: offset)");
  RangeErrorFit fit;
  const auto [near, far] = std::minmax_element(
      samples.begin(), samples.end(), [](const auto& a, const auto& b) { return a.range < b.range; });
  fit.nearest = near->range, fit.farthest = far->range;
  fit.rms_before = rms(samples, {});
  const double span = fit.farthest - fit.nearest;

  const double scale_sigma = settings.keep_scale ? 0.1 : settings.scale_sigma;

  double best_period = 0;
  const LinearFit plain(samples, 0, scale_sigma);
  double least = plain.squares();
  for (double period = shortest_period; period <= span; period *= 1.01) {
    const LinearFit wiggled(samples, period, scale_sigma);
    if (wiggled.squares() < least) least = wiggled.squares(), best_period = period;
  }
  // Three more unknowns, of which one was searched for, must gain more than chance gives them.
  const double noise = least / std::max(1.0, static_cast<double>(samples.size()) - 5);
  const bool wiggles = best_period > 0 && plain.squares() - least > 30 * std::max(1.0, noise);
  if (wiggles && take_wiggle(samples, best_period, scale_sigma, span, fit)) {
    fit.error.phase = std::remainder(fit.error.phase, 2 * M_PI);
  } else {
    fit.notes.push_back("no wiggle to be seen between " + metres(fit.nearest) + " and " +
                        metres(fit.farthest) + ": one whose period is longer than these " + metres(span) +
                        " would look like an offset; hold the board from 0.5 to 3 m and farther");
    fit.error.offset = plain.solution[0];
    fit.error.scale = plain.solution[1];
    fit.covariance.topLeftCorner<2, 2>() = plain.covariance;
  }
  const double freedom = std::max(1.0, static_cast<double>(samples.size()) - 5);
  fit.covariance *= std::max(1.0, weighted_squares(samples, fit.error) / freedom);
  fit.apparent_scale = fit.error.scale;
  if (!settings.keep_scale) {
    fit.error.scale = 0;
    fit.covariance.row(1).setZero();
    fit.covariance.col(1).setZero();
  }
  fit.rms_after = rms(samples, fit.error);
  return fit;
}

}  // namespace lcmslam
