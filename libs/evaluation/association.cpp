// Which pose of the estimate belongs to which of the truth (trajectory_error.hpp).

#include <algorithm>
#include <cmath>
#include <sstream>
#include <tuple>

#include <lcmslam/evaluation/trajectory_error.hpp>

namespace lcmslam {
namespace {

std::string describe(const char* name, const Trajectory& trajectory) {
  std::ostringstream text;
  text.precision(3);
  text << std::fixed << name << " (" << trajectory.size() << " poses";
  if (!trajectory.empty()) {
    text << ", " << 1e-6 * static_cast<double>(trajectory.front().utime) << " to "
         << 1e-6 * static_cast<double>(trajectory.back().utime) << " s";
  }
  text << ")";
  return text.str();
}

void check_sorted(const char* name, const Trajectory& trajectory) {
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    if (trajectory[i].utime <= trajectory[i - 1].utime) {
      throw std::invalid_argument(std::string(name) + ": stamp " + std::to_string(trajectory[i].utime) +
                                  " us does not come after " + std::to_string(trajectory[i - 1].utime) +
                                  " us; stamps must rise (sort_trajectory)");
    }
  }
}

Utime microseconds(double seconds) {
  return std::llround(seconds * 1e6);
}

// TUM's associate.py: all pairs closer than the limit, the closest first, each stamp used once.
std::vector<MatchedPose> nearest(const Trajectory& truth, const Trajectory& estimate, Utime limit,
                                 Utime offset) {
  std::vector<std::tuple<Utime, std::size_t, std::size_t>> candidates;
  std::size_t first = 0;
  for (std::size_t e = 0; e < estimate.size(); ++e) {
    const Utime utime = estimate[e].utime + offset;
    while (first < truth.size() && truth[first].utime <= utime - limit) ++first;
    for (std::size_t t = first; t < truth.size() && truth[t].utime < utime + limit; ++t) {
      candidates.emplace_back(std::abs(truth[t].utime - utime), t, e);
    }
  }
  std::sort(candidates.begin(), candidates.end());

  std::vector<char> truth_used(truth.size(), 0), estimate_used(estimate.size(), 0);
  std::vector<MatchedPose> matches;
  for (const auto& [difference, t, e] : candidates) {
    if (truth_used[t] || estimate_used[e]) continue;
    truth_used[t] = estimate_used[e] = 1;
    matches.push_back({estimate[e].utime + offset, truth[t].T_world_body, estimate[e].T_world_body,
                       estimate[e].covariance});
  }
  std::sort(matches.begin(), matches.end(),
            [](const MatchedPose& a, const MatchedPose& b) { return a.utime < b.utime; });
  return matches;
}

std::vector<MatchedPose> interpolated(const Trajectory& truth, const Trajectory& estimate, double max_gap,
                                      Utime offset) {
  std::vector<MatchedPose> matches;
  for (const StampedPose& pose : estimate) {
    const auto T_world_truth = pose_at(truth, pose.utime + offset, max_gap);
    if (T_world_truth)
      matches.push_back({pose.utime + offset, *T_world_truth, pose.T_world_body, pose.covariance});
  }
  return matches;
}

}  // namespace

std::vector<MatchedPose> associate(const Trajectory& truth, const Trajectory& estimate,
                                   const EvaluationSettings& settings) {
  check_sorted("truth", truth);
  check_sorted("estimate", estimate);
  const Utime offset = microseconds(settings.clock_offset);
  const double max_gap = 10 * settings.max_time_difference;
  const bool between = settings.association != Association::nearest;
  const auto matches = between ? interpolated(truth, estimate, max_gap, offset)
                               : nearest(truth, estimate, microseconds(settings.max_time_difference), offset);
  if (matches.empty()) {
    std::ostringstream text;
    text << "no pose of the " << describe("estimate", estimate)
         << (between ? " lies between two of the " : " belongs to one of the ") << describe("truth", truth)
         << (between ? " that are at most " : " within ")
         << (between ? max_gap : settings.max_time_difference) << " s" << (between ? " apart" : "")
         << ", clock offset " << settings.clock_offset << " s; both must be stamped by the same clock";
    throw std::invalid_argument(text.str());
  }
  return matches;
}

}  // namespace lcmslam
