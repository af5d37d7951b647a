#include "tools/farm/farm_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

constexpr int resamples = 4000;
constexpr std::size_t fewest_logs = 6;  // all to one side are chance in 2 of 64: below 5 %
constexpr double least_error = 1e-9;    // m; a perfect run has a logarithm, too

double log_ratio(const LogChange& change) {
  return std::log(std::max(change.after, least_error) / std::max(change.before, least_error));
}

PathChange change_of(const char* path, std::optional<double> FarmResult::*ate,
                     const std::vector<std::pair<const FarmResult*, const FarmResult*>>& pairs) {
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  PathChange change{path, {}, nothing, nothing, nothing, {}, {}};
  for (const auto& [before, after] : pairs) {
    if (before->*ate && after->*ate)
      change.logs.push_back({before->name, *(before->*ate), *(after->*ate)});
    else if (before->*ate || after->*ate)
      (before->*ate ? change.only_before : change.only_after).push_back(before->name);
  }
  if (change.logs.empty()) return change;
  const auto n = change.logs.size();
  double sum = 0;
  for (const LogChange& log : change.logs) sum += log_ratio(log);
  change.ratio = std::exp(sum / static_cast<double>(n));
  Random random(1);
  std::vector<double> means(resamples);
  for (double& mean : means) {
    double drawn = 0;
    for (std::size_t k = 0; k < n; ++k) drawn += log_ratio(change.logs[random.below(n)]);
    mean = drawn / static_cast<double>(n);
  }
  std::sort(means.begin(), means.end());
  change.low = std::exp(means[static_cast<std::size_t>(0.025 * resamples)]);
  change.high = std::exp(means[static_cast<std::size_t>(0.975 * resamples)]);
  std::stable_sort(change.logs.begin(), change.logs.end(),
                   [](const LogChange& a, const LogChange& b) { return log_ratio(a) > log_ratio(b); });
  return change;
}

}  // namespace

std::string PathChange::verdict() const {
  if (logs.size() < fewest_logs) return "no difference shown";
  if (high < 1) return "better";
  return low > 1 ? "worse" : "no difference shown";
}

FarmComparison compare_farms(const std::vector<FarmResult>& before, const std::vector<FarmResult>& after) {
  FarmComparison comparison;
  std::map<std::string, const FarmResult*> old;
  for (const FarmResult& result : before) old[result.name] = &result;
  std::vector<std::pair<const FarmResult*, const FarmResult*>> pairs;
  for (const FarmResult& result : after) {
    const auto found = old.find(result.name);
    if (found == old.end()) {
      comparison.added.push_back(result.name);
      continue;
    }
    pairs.emplace_back(found->second, &result);
    if (found->second->passed() && !result.passed()) comparison.broken.push_back(result.name);
    if (!found->second->passed() && result.passed()) comparison.mended.push_back(result.name);
    old.erase(found);
  }
  for (const auto& [name, result] : old) comparison.missing.push_back(name);
  comparison.paths = {change_of("icp", &FarmResult::icp, pairs),
                      change_of("fastslam", &FarmResult::fastslam, pairs)};
  return comparison;
}

}  // namespace lcmslam
