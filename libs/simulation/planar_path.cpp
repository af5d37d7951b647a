#include <lcmslam/simulation/planar_path.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lcmslam {
namespace {

constexpr int steps_per_segment = 200;  // of the arc length table
constexpr double arc_step = 0.005;      // m, of the speed profile
constexpr double time_step = 0.005;     // s, of the schedule
constexpr double smoothing = 0.4;       // s, window of each of the two moving averages

/// Value at a fractional index, clamped to the table.
double lookup(const std::vector<double>& table, double index) {
  if (!(index > 0)) return table.front();
  const auto i = static_cast<std::size_t>(index);
  if (i + 1 >= table.size()) return table.back();
  return table[i] + (index - static_cast<double>(i)) * (table[i + 1] - table[i]);
}

/// Centred moving average; the ends stay what they are.
std::vector<double> moving_average(const std::vector<double>& values, int half) {
  const int n = static_cast<int>(values.size());
  std::vector<double> sums(values.size() + 1, 0.0), result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) sums[i + 1] = sums[i] + values[i];
  for (int i = 0; i < n; ++i) {
    const int reach = std::min({half, i, n - 1 - i});
    result[static_cast<std::size_t>(i)] =
        (sums[static_cast<std::size_t>(i + reach + 1)] - sums[static_cast<std::size_t>(i - reach)]) /
        (2 * reach + 1);
  }
  return result;
}

}  // namespace

PlanarPath::PlanarPath(const std::vector<Eigen::Vector2d>& control_points, const PathLimits& limits,
                       const HeadingSway& sway)
    : sway_(sway) {
  if (control_points.size() < 2) throw std::invalid_argument("a path needs at least two points");
  for (std::size_t i = 1; i < control_points.size(); ++i)
    if (!((control_points[i] - control_points[i - 1]).norm() > 0.01))
      throw std::invalid_argument("neighbouring points of a path must be at least 0.01 m apart");
  // Mirrored phantom points make the curve start and end in the outer points without curvature.
  control_.push_back(2 * control_points[0] - control_points[1]);
  control_.insert(control_.end(), control_points.begin(), control_points.end());
  control_.push_back(2 * control_points.back() - control_points[control_points.size() - 2]);
  measure();
  schedule(limits);
}

// Segment i of a uniform cubic B-spline, t in 0..1, over control points i..i+3.
Eigen::Vector2d PlanarPath::point(double parameter) const {
  const double last = static_cast<double>(control_.size() - 4);
  const auto i = static_cast<std::size_t>(std::clamp(std::floor(parameter), 0.0, last));
  const double t = parameter - static_cast<double>(i), t2 = t * t, t3 = t2 * t;
  return ((1 - 3 * t + 3 * t2 - t3) * control_[i] + (4 - 6 * t2 + 3 * t3) * control_[i + 1] +
          (1 + 3 * t + 3 * t2 - 3 * t3) * control_[i + 2] + t3 * control_[i + 3]) /
         6;
}

Eigen::Vector2d PlanarPath::derivative(double parameter) const {
  const double last = static_cast<double>(control_.size() - 4);
  const auto i = static_cast<std::size_t>(std::clamp(std::floor(parameter), 0.0, last));
  const double t = parameter - static_cast<double>(i), t2 = t * t;
  return ((-1 + 2 * t - t2) * control_[i] + (-4 * t + 3 * t2) * control_[i + 1] +
          (1 + 2 * t - 3 * t2) * control_[i + 2] + t2 * control_[i + 3]) /
         2;
}

void PlanarPath::measure() {
  const std::size_t steps = (control_.size() - 3) * steps_per_segment;
  arc_length_.assign(1, 0.0);
  const double h = 1.0 / steps_per_segment;
  for (std::size_t i = 0; i < steps; ++i) {  // Simpson's rule
    const double a = static_cast<double>(i) * h;
    const double speed = derivative(a).norm() + 4 * derivative(a + h / 2).norm() + derivative(a + h).norm();
    arc_length_.push_back(arc_length_.back() + speed * h / 6);
  }
  length_ = arc_length_.back();
}

double PlanarPath::parameter_at(double arc_length) const {
  const auto upper = std::upper_bound(arc_length_.begin(), arc_length_.end(), arc_length);
  if (upper == arc_length_.begin()) return 0;
  const auto i = static_cast<std::size_t>(upper - arc_length_.begin()) - 1;
  if (i + 1 >= arc_length_.size()) return static_cast<double>(arc_length_.size() - 1) / steps_per_segment;
  const double fraction = (arc_length - arc_length_[i]) / (arc_length_[i + 1] - arc_length_[i]);
  return (static_cast<double>(i) + fraction) / steps_per_segment;
}

double PlanarPath::heading_at(double arc_length) const {
  const Eigen::Vector2d direction = derivative(parameter_at(arc_length));
  return std::atan2(direction.y(), direction.x()) +
         sway_.amplitude * std::sin(2 * M_PI * arc_length / sway_.wavelength);
}

// The fastest speed profile within the limits (forward and backward pass over the path), then
// smoothed in time so that acceleration is continuous.
void PlanarPath::schedule(const PathLimits& limits) {
  const auto count = static_cast<std::size_t>(std::ceil(length_ / arc_step)) + 1;
  const double step = length_ / static_cast<double>(count - 1);
  std::vector<double> speed(count, limits.speed);
  for (std::size_t i = 0; i < count; ++i) {
    const double s = static_cast<double>(i) * step;
    const double before = std::max(0.0, s - step), after = std::min(length_, s + step);
    const double turn = std::remainder(heading_at(after) - heading_at(before), 2 * M_PI) / (after - before);
    if (std::abs(turn) > 0) speed[i] = std::min(speed[i], limits.turn_rate / std::abs(turn));
  }
  speed.front() = speed.back() = 0;
  const double gain = 2 * limits.acceleration * step;
  for (std::size_t i = 1; i < count; ++i)
    speed[i] = std::min(speed[i], std::sqrt(speed[i - 1] * speed[i - 1] + gain));
  for (std::size_t i = count - 1; i-- > 0;)
    speed[i] = std::min(speed[i], std::sqrt(speed[i + 1] * speed[i + 1] + gain));

  std::vector<double> seconds(count, 0.0);
  for (std::size_t i = 1; i < count; ++i) seconds[i] = seconds[i - 1] + 2 * step / (speed[i - 1] + speed[i]);
  const auto resting = static_cast<std::size_t>(std::ceil((limits.rest + smoothing) / time_step));
  std::vector<double> raw(resting, 0.0);
  for (std::size_t i = 0; static_cast<double>(raw.size() - resting) * time_step < seconds.back();) {
    const double t = static_cast<double>(raw.size() - resting) * time_step;
    while (seconds[i + 1] < t) ++i;
    const double fraction = (t - seconds[i]) / (seconds[i + 1] - seconds[i]);
    // Constant acceleration between the speeds at both ends of the step.
    const double v0 = speed[i], v1 = speed[i + 1];
    const double local = fraction * (v0 + 0.5 * fraction * (v1 - v0)) / (0.5 * (v0 + v1));
    raw.push_back((static_cast<double>(i) + local) * step);
  }
  raw.insert(raw.end(), resting, length_);
  const int half = static_cast<int>(smoothing / time_step / 2);
  travelled_ = moving_average(moving_average(raw, half), half);
  double last = 0;  // rounding in the averages must not make the robot drive backwards
  for (double& travelled : travelled_)
    last = travelled = travelled > length_ - 1e-9 ? length_ : std::max(last, travelled);
}

double PlanarPath::duration() const {
  return static_cast<double>(travelled_.size() - 1) * time_step;
}

double PlanarPath::travelled(double seconds) const {
  return lookup(travelled_, seconds / time_step);
}

Eigen::Isometry3d PlanarPath::pose(double seconds) const {
  const double s = travelled(seconds);
  const Eigen::Vector2d position = point(parameter_at(s));
  return planar_pose(position.x(), position.y(), heading_at(s));
}

}  // namespace lcmslam
