#include "tools/farm/farm_comparison.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <map>

namespace lcmslam {
namespace {

constexpr std::size_t fewest_logs = 6;  // all to one side are chance in 2 of 64; of fewer above 5 %
constexpr double least_error = 1e-9;    // m; a perfect run has a logarithm, too

double log_ratio(const LogChange& change) {
  return std::log(std::max(change.after, least_error) / std::max(change.before, least_error));
}

PathChange change_of(const char* path, std::optional<double> FarmResult::*ate, int FarmResult::*restarts,
                     const std::vector<std::pair<const FarmResult*, const FarmResult*>>& pairs) {
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  PathChange change{path, {}, nothing, nothing, nothing, {}, {}, {}};
  for (const auto& [before, after] : pairs) {
    if (before->*restarts > 0 || after->*restarts > 0)
      change.restarted.push_back(before->name);
    else if (before->*ate && after->*ate)
      change.logs.push_back({before->name, *(before->*ate), *(after->*ate)});
    else if (before->*ate || after->*ate)
      (before->*ate ? change.only_before : change.only_after).push_back(before->name);
  }
  if (change.logs.empty()) return change;
  const auto n = static_cast<double>(change.logs.size());
  double mean = 0, squares = 0;
  for (const LogChange& log : change.logs) mean += log_ratio(log) / n;
  for (const LogChange& log : change.logs) squares += std::pow(log_ratio(log) - mean, 2);
  change.ratio = std::exp(mean);
  if (change.logs.size() > 1) {
    const double t = boost::math::quantile(boost::math::students_t(n - 1), 0.975);
    const double half = t * std::sqrt(squares / (n - 1) / n);
    change.low = std::exp(mean - half);
    change.high = std::exp(mean + half);
  }
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
  comparison.paths = {change_of("icp", &FarmResult::icp, &FarmResult::icp_restarts, pairs),
                      change_of("fastslam", &FarmResult::fastslam, &FarmResult::fastslam_restarts, pairs)};
  return comparison;
}

}  // namespace lcmslam
