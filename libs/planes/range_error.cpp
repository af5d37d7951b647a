#include <lcmslam/planes/range_error.hpp>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr int least_width = 64;          // pixels; of smaller images hardly a plane can be told
constexpr double knot_step = 0.25;       // m
constexpr double samples_wanted = 6000;  // of an image
constexpr double rim_share = 1.0 / 30;   // of the image's width
constexpr int parts_across = 22;         // of an image
constexpr double least_slant = 0.1;      // of n . u: at a grazing view a plane says little of the range
constexpr double most_sigma = 0.05;      // m, of depth
constexpr double farthest_knot = 12;     // m
constexpr double negligible = 2e-4;      // m

// `error` in mm, `fine` of its entries a mm of range.
LCMSLAM_VECTORISED(correct_row,
                   (std::uint16_t* __restrict z, const float* __restrict length,
                    const float* __restrict error, int last, float fine, int n),
                   (z, length, error, last, fine, n)) {
  for (int u = 0; u < n; ++u) {
    const int measured = z[u];
    const auto depth = static_cast<float>(measured);
    const int entry = static_cast<int>(depth * length[u] * fine + 0.5F);
    const float corrected = depth - error[std::min(entry, last)] / length[u] + 0.5F;
    const int rounded = static_cast<int>(std::max(corrected, 1.F));
    z[u] = static_cast<std::uint16_t>(measured == 0 ? 0 : rounded);
  }
}

RangeErrorSettings checked_settings(const RangeErrorSettings& settings) {
  check(settings, "range_error");
  return settings;
}

// Farther than elsewhere: many pixels tell together. Some more for cells, so that which of them are planes
// does not depend on the noise of those that count.
FramePlaneSettings large_planes() {
  FramePlaneSettings settings;
  settings.max_sigma = 1.5 * most_sigma;
  settings.flatness = 1;
  settings.max_distance_sigmas = 2;
  settings.min_cells = 60;  // of some 1300
  return settings;
}

/// Covariance of a smooth function of the range at the knots.
Eigen::MatrixXd smooth(double sigma, double length, Eigen::Index knots) {
  Eigen::MatrixXd K(knots, knots);
  for (Eigen::Index i = 0; i < knots; ++i)
    for (Eigen::Index j = 0; j < knots; ++j) {
      const double apart = knot_step * static_cast<double>(i - j) / length;
      K(i, j) = sigma * sigma * (std::exp(-0.5 * apart * apart) + (i == j ? 1e-3 : 0));
    }
  return K;
}

// Near the edge of two planes it is the noise that decides which of them a pixel belongs to.
bool is_inside(const cv::Mat& labels, int v, int u, int rim) {
  const std::uint8_t label = labels.at<std::uint8_t>(v, u);
  return labels.at<std::uint8_t>(v - rim, u) == label && labels.at<std::uint8_t>(v + rim, u) == label &&
         labels.at<std::uint8_t>(v, u - rim) == label && labels.at<std::uint8_t>(v, u + rim) == label;
}

}  // namespace

RangeError::RangeError(const RgbdCalibration& calibration, const RangeErrorSettings& settings)
    : settings_(checked_settings(settings)),
      rays_(ray_table(calibration.depth_registered ? calibration.colour : calibration.depth)),
      noise_(calibration.depth_noise) {
  ray_lengths_.create(rays_.size());
  std::transform(rays_.begin(), rays_.end(), ray_lengths_.begin(),
                 [](const cv::Vec2f& ray) { return std::sqrt(1 + ray.dot(ray)); });
  if (settings_.enabled && rays_.cols >= least_width) planes_.emplace(calibration, large_planes());
  const double reach = std::min(farthest_knot, 1.3 * calibration.depth_max);  // to the image's corners
  const auto knots = static_cast<Eigen::Index>(std::ceil(reach / knot_step)) + 2;
  known_.covariance = smooth(noise_.constant, settings_.length, knots);
  known_.information = prior_ = known_.covariance.llt().solve(Eigen::MatrixXd::Identity(knots, knots));
  information_.setZero(knots, knots);
  told_.setZero(knots);
  known_.mean.setZero(knots);
}

void RangeError::learn(const cv::Mat& depth, Utime utime) {
  const bool due = !looked_ || utime < last_ || 1e-6 * static_cast<double>(utime - last_) >= settings_.period;
  if (!planes_ || !due || depth.empty()) return;
  looked_ = true;
  last_ = utime;
  information_ *= 1 - 1 / settings_.memory;
  told_ *= 1 - 1 / settings_.memory;
  const FramePlanes found = (*planes_)(depth);
  std::vector<std::vector<PlaneSample>> samples(found.planes.size());
  const int step = std::max(
      1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(depth.total()) / samples_wanted))));
  const int side = (depth.cols + parts_across - 1) / parts_across;
  const int rim = std::max(2, static_cast<int>(rim_share * depth.cols));
  for (int v = rim; v < depth.rows - rim; v += step)
    for (int u = rim; u < depth.cols - rim; u += step) {
      const std::uint8_t label = found.labels.at<std::uint8_t>(v, u);
      if (label == 0 || !is_inside(found.labels, v, u, rim)) continue;
      const auto plane = static_cast<std::size_t>(label - 1);
      const double z = 1e-3 * depth.at<std::uint16_t>(v, u);
      const int cell = v / side * parts_across + u / side;
      if (const auto sample = sample_of(found.planes[plane].fit, rays_(v, u), z, cell))
        samples[plane].push_back(*sample);
    }
  for (const std::vector<PlaneSample>& of_plane : samples) add_plane(of_plane);
  solve();
}

// All is told at the range where the ray meets the plane, and not at the measured one: a point that noise
// moves would be told apart by the noise.
std::optional<PlaneSample> RangeError::sample_of(const PlaneFit& fit, const cv::Vec2f& pixel, double z,
                                                 int cell) const {
  const Eigen::Vector3d ray(static_cast<double>(pixel[0]), static_cast<double>(pixel[1]), 1);
  const double length = ray.norm(), slant = fit.plane.normal.dot(ray) / length;
  if (!(z > 0) || std::abs(slant) < least_slant) return std::nullopt;
  const double range = -fit.plane.offset / slant, sigma = noise_.sigma(range / length);
  const double knot = std::floor(range / knot_step);
  if (!(range > 0) || sigma > most_sigma || knot + 1 >= static_cast<double>(known_.mean.size()))
    return std::nullopt;
  const Eigen::Vector3d x = range / length * ray - fit.centre;
  const Eigen::Vector3d turned = fit.plane.normal.cross(fit.axis);
  return PlaneSample{cell,
                     static_cast<Eigen::Index>(knot),
                     range / knot_step - knot,
                     z * length - range,
                     sigma * sigma,
                     slant,
                     x,
                     Eigen::Vector3d(fit.axis.dot(x), turned.dot(x), 1) / slant};
}

// A plane that fits badly to what is known, because it is none, counts for less.
void RangeError::add_plane(const std::vector<PlaneSample>& samples) {
  const ToldOfCurve told = told_by_plane(samples, parts_across, known_, settings_.unevenness);
  const double weight = 1 / std::max(1.0, told.misfit);
  information_ += weight * told.information;
  told_ += weight * told.vector;
}

void RangeError::solve() {
  known_.information = information_ + prior_;
  const Eigen::LLT<Eigen::MatrixXd> root(known_.information);
  known_.mean = root.solve(told_);
  known_.covariance = root.solve(Eigen::MatrixXd::Identity(prior_.rows(), prior_.cols()));
  const double prior = noise_.constant * noise_.constant;
  const Eigen::ArrayXd told =
      (1 - known_.covariance.diagonal().array() / prior).max(0);  // the share of each knot
  learned_ = (told * known_.mean.array().square()).sum() / std::max(1.0, told.sum());
}

double RangeError::at(double range) const {
  const double knot = std::clamp(range / knot_step, 0.0, static_cast<double>(known_.mean.size() - 1) - 1e-9);
  const auto k = static_cast<Eigen::Index>(knot);
  const double beyond = knot - static_cast<double>(k);
  return (1 - beyond) * known_.mean(k) + beyond * known_.mean(k + 1);
}

double RangeError::sigma(double range) const {
  const double knot = std::clamp(range / knot_step, 0.0, static_cast<double>(known_.mean.size() - 1));
  const auto k = static_cast<Eigen::Index>(std::lround(knot));
  return std::sqrt(known_.covariance(k, k));
}

// How much of the constant part was an error by range is seen by how large what was learned is; the rest of
// it is new in each image and stays.
double RangeError::remaining(double stated, double range) const {
  const double prior = noise_.constant * noise_.constant, unknown = sigma(range);
  const double left = std::sqrt(std::max(prior - learned_, unknown * unknown));
  return std::max(0.0, stated - noise_.constant) + std::min(noise_.constant, left);
}

void RangeError::correct(cv::Mat& depth) const {
  if (largest() < negligible) return;
  constexpr int fine = 100;  // a metre
  std::vector<float> error(
      static_cast<std::size_t>(fine * knot_step * static_cast<double>(known_.mean.size())) + 1);
  for (std::size_t i = 0; i < error.size(); ++i)
    error[i] = static_cast<float>(1000 * at(static_cast<double>(i) / fine));
  for (int v = 0; v < depth.rows; ++v)
    correct_row(depth.ptr<std::uint16_t>(v), ray_lengths_[v], error.data(),
                static_cast<int>(error.size()) - 1, fine * 1e-3F, depth.cols);
}

}  // namespace lcmslam
