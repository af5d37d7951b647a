#include <lcmslam/simulation/repeated_lap.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

/// s: when the robot has driven so many m; bisection, as the way driven never shrinks.
double time_of(const PlanarPath& path, double travelled) {
  double low = 0, high = path.duration();
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (path.travelled(middle) < travelled ? low : high) = middle;
  }
  return high;
}

}  // namespace

// Half a lap after the start and half a lap before the end the robot does not know any more, or yet, that it
// stands there.
RepeatedLap::RepeatedLap(const PlanarPath& path, double lap_length, int repeats, Utime image_period)
    : repeats_(repeats), length_(lap_length) {
  const double begin = time_of(path, 0.5 * lap_length);
  const double planned_period = time_of(path, 1.5 * lap_length) - begin;
  const auto images = static_cast<Utime>(std::ceil(1e6 * planned_period / static_cast<double>(image_period)));
  period_ = images * image_period;
  stretch_ = 1e6 * planned_period / static_cast<double>(period_);
  begin_ = static_cast<Utime>(1e6 * begin / stretch_);
}

double RepeatedLap::driven(double planned_duration) const {
  return planned_duration / stretch_ + 1e-6 * static_cast<double>(repeats_ * period_);
}

Utime RepeatedLap::first(Utime elapsed) const {
  if (!repeats() || elapsed < begin_ + period_) return elapsed;
  if (elapsed >= begin_ + (repeats_ + 1) * period_) return elapsed - repeats_ * period_;
  return begin_ + (elapsed - begin_) % period_;
}

bool RepeatedLap::comes_again(Utime first_moment) const {
  return repeats() && first_moment >= begin_ && first_moment < begin_ + period_;
}

double RepeatedLap::planned(double seconds) const {
  if (!repeats()) return seconds;
  const double begin = 1e-6 * static_cast<double>(begin_), period = 1e-6 * static_cast<double>(period_);
  const double laps = std::clamp(std::floor((seconds - begin) / period), 0.0, static_cast<double>(repeats_));
  return (seconds - laps * period) * stretch_;
}

}  // namespace lcmslam
