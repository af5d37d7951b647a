#include <lcmslam/datasets/problem_summary.hpp>

#include <algorithm>
#include <cctype>

namespace lcmslam {
namespace {

struct Kind {
  std::string reason, first;
  std::size_t count;
};

/// Behind the file's name, without digits.
std::string reason_of(const std::string& problem) {
  const std::size_t colon = problem.find(": ");
  std::string reason = colon == std::string::npos ? problem : problem.substr(colon);
  reason.erase(
      std::remove_if(reason.begin(), reason.end(), [](unsigned char c) { return std::isdigit(c) != 0; }),
      reason.end());
  return reason;
}

}  // namespace

std::vector<std::string> summarise_problems(const std::vector<std::string>& problems) {
  std::vector<Kind> kinds;
  for (const std::string& problem : problems) {
    const std::string reason = reason_of(problem);
    const auto known =
        std::find_if(kinds.begin(), kinds.end(), [&](const Kind& kind) { return kind.reason == reason; });
    if (known == kinds.end())
      kinds.push_back({reason, problem, 1});
    else
      ++known->count;
  }
  std::vector<std::string> lines;
  lines.reserve(kinds.size());
  for (const Kind& kind : kinds)
    lines.push_back(kind.count == 1 ? kind.first
                                    : std::to_string(kind.count) + " times, first " + kind.first);
  return lines;
}

}  // namespace lcmslam
