#include <lcmslam/evaluation/trajectory_error.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <lcmslam/evaluation/consistency.hpp>
#include <lcmslam/evaluation/median.hpp>

namespace lcmslam {
namespace {

struct ErrorLists {
  std::vector<double> translation, rotation;
  void add(const Eigen::Isometry3d& error) {
    translation.push_back(error.translation().norm());
    rotation.push_back(rotation_angle(error));
  }
  PoseErrors summary() const { return {statistics(translation), statistics(rotation)}; }
};

// How far along each match is, in the unit of the step; rises with the index.
std::vector<double> progress(const std::vector<MatchedPose>& matches, StepUnit unit) {
  std::vector<double> values(matches.size(), 0.0);
  for (std::size_t i = 1; i < matches.size(); ++i) {
    const MatchedPose& a = matches[i - 1];
    const MatchedPose& b = matches[i];
    double step = 1;
    if (unit == StepUnit::seconds) step = 1e-6 * static_cast<double>(b.utime - a.utime);
    if (unit == StepUnit::metres)
      step = (b.T_world_truth.translation() - a.T_world_truth.translation()).norm();
    values[i] = values[i - 1] + step;
  }
  return values;
}

std::optional<std::size_t> nearest_to(const std::vector<double>& values, double wanted, double tolerance) {
  const auto after = std::lower_bound(values.begin(), values.end(), wanted);
  std::optional<std::size_t> best;
  double best_difference = tolerance;
  for (auto it = after == values.begin() ? after : std::prev(after); it != values.end() && it <= after;
       ++it) {
    const double difference = std::abs(*it - wanted);
    if (difference <= best_difference) {
      best_difference = difference;
      best = static_cast<std::size_t>(it - values.begin());
    }
  }
  return best;
}

// s, between one pose and the next; NaN below two.
double median_step(const Trajectory& poses) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < poses.size(); ++i)
    steps.push_back(1e-6 * static_cast<double>(poses[i].utime - poses[i - 1].utime));
  return median(std::move(steps));
}

// What comes each two seconds by design is not lost between.
double tracking_gap(const Trajectory& truth, const Trajectory& estimate, double least) {
  constexpr double usual_steps = 3;
  double gap = least;
  for (const Trajectory* poses : {&truth, &estimate})
    if (const double step = median_step(*poses); std::isfinite(step)) gap = std::max(gap, usual_steps * step);
  return gap;
}

double tracked_fraction(const Trajectory& truth, const std::vector<MatchedPose>& matches, double max_gap) {
  // Time in steps of at most max_gap.
  const auto covered = [&](const auto& poses) {
    double sum = 0;
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const double step = 1e-6 * static_cast<double>(poses[i].utime - poses[i - 1].utime);
      if (step <= max_gap) sum += step;
    }
    return sum;
  };
  const double whole = covered(truth);
  return whole > 0 ? std::min(1.0, covered(matches) / whole) : std::numeric_limits<double>::quiet_NaN();
}

/// As free as the alignment.
WorldFit world_fit(Alignment alignment) {
  if (alignment == Alignment::se2) return WorldFit::ground;
  return alignment == Alignment::se3 ? WorldFit::space : WorldFit::none;
}

/// Fewer poses than the alignment has to fit agree with any truth.
void check_enough(std::size_t matched, Alignment alignment) {
  const std::size_t fewest = alignment == Alignment::none ? 1 : alignment == Alignment::first_pose ? 2 : 3;
  if (matched < fewest)
    throw std::invalid_argument(
        "only " + std::to_string(matched) +
        " poses belong to one of the truth; with this alignment errors mean something from " +
        std::to_string(fewest) + " on");
}

}  // namespace

ErrorStatistics statistics(std::vector<double> errors) {
  ErrorStatistics s;
  s.count = errors.size();
  if (errors.empty()) {
    s.rmse = s.mean = s.median = s.maximum = std::numeric_limits<double>::quiet_NaN();
    return s;
  }
  const auto n = static_cast<double>(errors.size());
  double squares = 0;
  for (const double error : errors) {
    s.mean += error / n;
    squares += error * error / n;
  }
  s.rmse = std::sqrt(squares);
  std::sort(errors.begin(), errors.end());
  const std::size_t middle = errors.size() / 2;
  s.median = errors.size() % 2 == 1 ? errors[middle] : 0.5 * (errors[middle - 1] + errors[middle]);
  s.maximum = errors.back();
  return s;
}

PoseErrors absolute_errors(const std::vector<MatchedPose>& matches) {
  ErrorLists errors;
  for (const MatchedPose& match : matches) {
    errors.translation.push_back(
        (match.T_world_estimate.translation() - match.T_world_truth.translation()).norm());
    errors.rotation.push_back(rotation_angle(match.T_world_truth.inverse() * match.T_world_estimate));
  }
  return errors.summary();
}

PoseErrors relative_errors(const std::vector<MatchedPose>& matches, double step, StepUnit unit) {
  if (!(step > 0)) throw std::invalid_argument("step of the relative pose error must be above 0");
  const std::vector<double> position = progress(matches, unit);
  ErrorLists errors;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const auto j = nearest_to(position, position[i] + step, unit == StepUnit::frames ? 1e-9 : 0.1 * step);
    if (!j || *j <= i) continue;
    const Eigen::Isometry3d truth = matches[i].T_world_truth.inverse() * matches[*j].T_world_truth;
    const Eigen::Isometry3d estimate = matches[i].T_world_estimate.inverse() * matches[*j].T_world_estimate;
    errors.add(truth.inverse() * estimate);
  }
  return errors.summary();
}

TrajectoryReport evaluate(const Trajectory& truth, const Trajectory& estimate,
                          const EvaluationSettings& settings) {
  TrajectoryReport report;
  report.matches = associate(truth, estimate, settings);
  check_enough(report.matches.size(), settings.alignment);
  report.truth_poses = truth.size();
  report.estimate_poses = estimate.size();
  report.matched_poses = report.matches.size();
  report.tracking_gap = tracking_gap(truth, estimate, settings.max_tracking_gap);
  report.tracked_fraction = tracked_fraction(truth, report.matches, report.tracking_gap);
  report.truth_length = progress(report.matches, StepUnit::metres).back();

  report.alignment = find_alignment(report.matches, settings.alignment);
  report.matches = align(std::move(report.matches), report.alignment);

  report.absolute = absolute_errors(report.matches);
  report.per_frame = relative_errors(report.matches, 1, StepUnit::frames);
  report.per_second = relative_errors(report.matches, 1, StepUnit::seconds);
  report.per_metre = relative_errors(report.matches, 1, StepUnit::metres);
  if (settings.alignment != Alignment::sim3)  // covariances know of no scale
    report.consistency = consistency(report.matches, {world_fit(settings.alignment), settings.fit_body});
  return report;
}

}  // namespace lcmslam
