#include <lcmslam/evaluation/clock_offset.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

namespace lcmslam {
namespace {

constexpr std::size_t fewest_poses = 10;
constexpr std::size_t most_poses = 4000;  // of longer trajectories every second, third ... is compared
constexpr double noticeable = 1.05;       // a larger error than the least
constexpr double smallest_error = 1e-6;   // m: below it nothing is told apart
constexpr double golden = 0.618033988749895;

Utime shifted(Utime utime, double offset) {
  return utime + std::llround(1e6 * offset);
}

Trajectory thinned(const Trajectory& trajectory, std::size_t most) {
  const std::size_t stride = (trajectory.size() + most - 1) / most;
  if (stride < 2) return trajectory;
  Trajectory result;
  for (std::size_t i = 0; i < trajectory.size(); i += stride) result.push_back(trajectory[i]);
  return result;
}

/// Grid over -range..range; 0 is one of its points.
std::vector<double> grid(const ClockOffsetSearch& search) {
  const auto half = static_cast<int>(std::ceil(search.range / search.step - 1e-9));
  std::vector<double> offsets;
  for (int i = -half; i <= half; ++i) offsets.push_back(search.range * i / half);
  return offsets;
}

/// Poses of the estimate that have a truth at every one of the offsets.
Trajectory comparable(const Trajectory& truth, const Trajectory& estimate, const std::vector<double>& offsets,
                      double max_gap) {
  Trajectory result;
  for (const StampedPose& pose : estimate) {
    const bool everywhere = std::all_of(offsets.begin(), offsets.end(), [&](double offset) {
      return pose_at(truth, shifted(pose.utime, offset), max_gap).has_value();
    });
    if (everywhere) result.push_back(pose);
  }
  return result;
}

/// Least value of a function that has one minimum between low and high.
double golden_section(const std::function<double(double)>& f, double low, double high, double tolerance) {
  double a = high - golden * (high - low), b = low + golden * (high - low);
  double fa = f(a), fb = f(b);
  while (high - low > tolerance) {
    if (fa < fb) {
      high = b;
      b = a, fb = fa;
      a = high - golden * (high - low), fa = f(a);
    } else {
      low = a;
      a = b, fa = fb;
      b = low + golden * (high - low), fb = f(b);
    }
  }
  return 0.5 * (low + high);
}

}  // namespace

ClockOffset estimate_clock_offset(const Trajectory& truth, const Trajectory& estimate,
                                  EvaluationSettings settings, const ClockOffsetSearch& search) {
  if (!(search.range > 0 && search.step > 0 && search.tolerance > 0))
    throw std::invalid_argument("clock offset: range, step and tolerance must be above 0");
  if (settings.alignment == Alignment::first_pose) settings.alignment = Alignment::se3;
  const double max_gap = 10 * settings.max_time_difference;
  const std::vector<double> offsets = grid(search);
  const Trajectory poses = comparable(truth, thinned(estimate, most_poses), offsets, max_gap);
  if (poses.size() < fewest_poses)
    throw std::invalid_argument("clock offset: only " + std::to_string(poses.size()) +
                                " poses have a truth at all offsets of +-" + std::to_string(search.range) +
                                " s; at least " + std::to_string(fewest_poses) + " are needed");

  const auto error = [&](double offset) {
    std::vector<MatchedPose> matches;
    for (const StampedPose& pose : poses) {
      if (const auto T = pose_at(truth, shifted(pose.utime, offset), max_gap))
        matches.push_back({pose.utime, *T, pose.T_world_body});
    }
    return absolute_errors(align(matches, find_alignment(matches, settings.alignment))).translation.rmse;
  };

  std::vector<double> errors;
  for (const double offset : offsets) errors.push_back(error(offset));
  const auto least =
      static_cast<std::size_t>(std::min_element(errors.begin(), errors.end()) - errors.begin());
  const double low = offsets[least == 0 ? 0 : least - 1];
  const double high = offsets[std::min(least + 1, offsets.size() - 1)];

  ClockOffset result;
  result.offset = golden_section(error, low, high, search.tolerance);
  result.ate = error(result.offset);
  if (errors[least] < result.ate) {
    result.offset = offsets[least];
    result.ate = errors[least];
  }
  result.ate_zero = error(0);
  result.compared_poses = poses.size();

  // The neighbourhood in which the error is not noticeably larger: whole steps first.
  const double limit = std::max(noticeable * result.ate, result.ate + smallest_error);
  std::size_t last = 0;
  while (last + 1 < offsets.size() && offsets[last] < result.offset) ++last;
  std::size_t first = last;
  while (first > 0 && offsets[first] > result.offset) --first;
  while (first > 0 && errors[first] <= limit) --first;
  while (last + 1 < errors.size() && errors[last] <= limit) ++last;
  const auto crossing = [&](double inside, double outside) {
    for (int i = 0; i < 20; ++i) {
      const double middle = 0.5 * (inside + outside);
      (error(middle) <= limit ? inside : outside) = middle;
    }
    return inside;
  };
  result.low = errors[first] <= limit ? offsets[first] : crossing(result.offset, offsets[first]);
  result.high = errors[last] <= limit ? offsets[last] : crossing(result.offset, offsets[last]);
  result.determined = errors[first] > limit && errors[last] > limit;
  return result;
}

}  // namespace lcmslam
