#include <lcmslam/calibration/self/sighting_comparison.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/calibration/self/depth_patch.hpp>
#include <lcmslam/calibration/self/surface_slopes.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t fewest_pixels = 100;
// Far off: a robust weight is enough nearer by, and gates that follow the scale of what they let through
// would close on whatever the first rounds liked.
constexpr double outlier_sigmas = 20;  // of the scale that was seen
constexpr double least_pixel = 0.05;   // pixels and shares of depth's noise: scales below are none
constexpr double least_depth = 0.05;
constexpr double near_gate = 4,
                 near_depth_gate = 2;  // pixels, shares of depth's noise: nothing nearer is an outlier

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The keyframes' inverse depths freed of what all ranges err by, as far as that is known: a wide patch of a
/// slanted surface holds a good part of a wiggle, which neither moves it as its middle's error does nor
/// leaves it a plane.
std::vector<cv::Mat> freed_depths(const BundleState& state, const CameraModel& camera) {
  std::vector<cv::Mat> images;
  for (const ObservedKeyframe& keyframe : state.scene.keyframes) images.push_back(keyframe.inverse_depth);
  const RangeCurve& curve = state.curve;
  if (std::all_of(curve.values.begin(), curve.values.end(), [](double value) { return value == 0; }))
    return images;
  const cv::Mat rays = ray_table(camera);
  for (cv::Mat& image : images) {
    image = image.clone();
    for (int v = 0; v < image.rows; ++v) {
      auto* inverse = image.ptr<float>(v);
      const auto* ray = rays.ptr<cv::Vec2f>(v);
      for (int u = 0; u < image.cols; ++u) {
        if (!(inverse[u] > 0)) continue;
        const auto x = static_cast<double>(ray[u][0]), y = static_cast<double>(ray[u][1]);
        const double length = std::sqrt(1 + x * x + y * y), range = length / static_cast<double>(inverse[u]);
        inverse[u] = static_cast<float>(length / (range + curve.at(curve.place(range))));
      }
    }
  }
  return images;
}

class Comparer {
 public:
  Comparer(const BundleState& state, const BundleSettings& settings, const Comparisons* former)
      : state_(state),
        settings_(settings),
        former_(former),
        depth_camera_(state.model.depth()),
        T_depth_colour_(state.model.T_colour_depth().inverse()),
        inverse_depths_(freed_depths(state, depth_camera_)) {}

  /// Pixels by the sighting's sigma; nothing where it is another landmark.
  std::optional<double> look_in_colour(const LandmarkSighting& sighting, Comparison& c) const {
    const HeadNumbers& h = state_.model.values;
    c.pixel.T_start = state_.starts[c.keyframe];
    c.pixel.twist = state_.scene.keyframes[c.keyframe].twist;
    c.pixel.pixel = sighting.pixel;
    c.pixel.row = (sighting.pixel.y() + 0.5) / state_.model.start.colour.height - 0.5;
    std::copy(state_.rational, state_.rational + 3, c.pixel.rational);
    c.pixel.sigma = sighting.sigma;
    double seen[2];
    const Eigen::Vector3d p =
        state_.seen_by_colour(c.keyframe, c.landmark, c.pixel.row * h[head::colour_rows]);
    if (!residuals::project(h.data() + head::fx, state_.rational, p, seen)) return std::nullopt;
    const double error = (Eigen::Vector2d(seen[0], seen[1]) - sighting.pixel).norm();
    const double gate = former_ == nullptr
                            ? settings_.pixel_gate
                            : std::max(near_gate, outlier_sigmas * former_->pixel_scale) * sighting.sigma;
    if (error > gate) return std::nullopt;
    return error / sighting.sigma;
  }

  /// Shares of the depth's noise; nothing without a surface there.
  std::optional<double> look_in_depth(Comparison& c) const {
    const HeadNumbers& h = state_.model.values;
    const ObservedKeyframe& keyframe = state_.scene.keyframes[c.keyframe];
    // The row is that of the pixel where the landmark lies in the depth image: two looks find it.
    c.lag = keyframe.depth_lag;
    std::optional<Eigen::Vector2d> pixel;
    Eigen::Vector3d p;
    for (int look = 0; look < 2; ++look) {
      p = T_depth_colour_ * state_.seen_by_colour(c.keyframe, c.landmark,
                                                  c.lag + h[head::depth_clock] + c.row * h[head::depth_rows]);
      pixel = depth_camera_.project(p);
      if (!pixel) return std::nullopt;
      c.row = std::clamp((pixel->y() + 0.5) / depth_camera_.height - 0.5, -0.5, 0.5);
    }
    const cv::Mat& inverse_depth = inverse_depths_[c.keyframe];
    if (inverse_depth.empty()) return std::nullopt;
    c.patch = depth_patch(inverse_depth, *pixel, depth_camera_, state_.model.start.depth_noise);
    if (!c.patch) return std::nullopt;
    // By where the landmark is, not by what was measured: there a world that shrinks would take its noise
    // along.
    c.range = state_.curve.place(p.norm());
    c.patch->freed = state_.curve.at(c.range);
    const double error = std::abs(
        residuals::depth_error<double>(*c.patch, pixel->data(), p, h.data() + head::depth_scale, 0.0));
    const double gate =
        former_ == nullptr ? settings_.depth_gate / c.patch->sigma : outlier_sigmas * former_->depth_scale;
    if (error < std::max(near_depth_gate, gate)) return error;
    c.patch.reset();
    return std::nullopt;
  }

  void share_slopes_of(Comparison* first, Comparison* last) const {
    share_slopes(first, last, state_, depth_camera_, T_depth_colour_);
  }

 private:
  const BundleState& state_;
  const BundleSettings& settings_;
  const Comparisons* former_;
  CameraModel depth_camera_;
  Eigen::Isometry3d T_depth_colour_;
  std::vector<cv::Mat> inverse_depths_;  // of each keyframe
};

}  // namespace

Comparisons compare(const BundleState& state, const BundleSettings& settings, const Comparisons* former) {
  const Comparer comparer(state, settings, former);
  Comparisons result;
  std::vector<double> pixel_errors, depth_errors;
  for (std::size_t l = 0; l < state.scene.landmarks.size(); ++l) {
    const std::size_t first = result.all.size();
    for (const LandmarkSighting& sighting : state.scene.landmarks[l].sightings) {
      Comparison c{static_cast<std::size_t>(sighting.keyframe), l, {}, {}, {}};
      const auto pixels_off = comparer.look_in_colour(sighting, c);
      if (!pixels_off) continue;
      pixel_errors.push_back(*pixels_off);
      if (const auto depth_off = comparer.look_in_depth(c)) depth_errors.push_back(*depth_off);
      result.all.push_back(c);
    }
    comparer.share_slopes_of(result.all.data() + first, result.all.data() + result.all.size());
  }
  if (result.all.size() < fewest_pixels)
    throw std::runtime_error("self calibration: only " + std::to_string(result.all.size()) +
                             " sightings of landmarks agree with their keyframes; at least " +
                             std::to_string(fewest_pixels) + " are needed");
  result.pixels = static_cast<int>(pixel_errors.size());
  result.depths = static_cast<int>(depth_errors.size());
  // Of the length of two normal numbers the median is 1.1774 sigma, of one's absolute value 0.6745.
  result.pixel_scale = std::max(least_pixel, median(pixel_errors) / 1.1774);
  result.depth_scale = depth_errors.empty() ? 1 : std::max(least_depth, median(depth_errors) / 0.6745);
  return result;
}

}  // namespace lcmslam
