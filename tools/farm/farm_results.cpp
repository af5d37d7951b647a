#include "tools/farm/farm_results.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <tuple>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string last_line(const fs::path& file) {
  std::ifstream in(file);
  std::string last;
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) last = line;
  return last;
}

std::optional<double> ate(const json& summary, const char* path) {
  const json::json_pointer place(std::string("/paths/") + path + "/ate/translation_rmse_m");
  return summary.contains(place) ? std::optional(summary[place].get<double>()) : std::nullopt;
}

}  // namespace

double FarmResult::badness() const {
  const double worst = std::max(icp.value_or(0), fastslam.value_or(0));
  return odometry && *odometry > 0 ? worst / *odometry : worst;
}

FarmResult read_result(const fs::path& folder, const Expectations& expectations) {
  FarmResult result;
  result.name = folder.filename().string();
  std::ifstream in(folder / "summary.json");
  const json summary = in ? json::parse(in, nullptr, false) : json();
  result.has_summary = summary.is_object();
  if (!result.has_summary) {
    const std::string said = last_line(folder / "batch.txt");
    result.failures.push_back(said.empty() ? "it did not end, and said nothing" : said);
    return result;
  }
  try {
    result.failures = expectations.failures(result.name, summary);
    result.key = summary.value("key", "");
    result.icp = ate(summary, "icp");
    result.fastslam = ate(summary, "fastslam");
    result.odometry = ate(summary, "odometry");
    result.icp_restarts = summary.value("/paths/icp/restarts"_json_pointer, 0);
    result.fastslam_restarts = summary.value("/paths/fastslam/restarts"_json_pointer, 0);
    result.frames = summary.value("frames", 0.0);
    result.seconds = summary.value("/timing/wall_seconds"_json_pointer, 0.0);
  } catch (const json::exception& error) {
    throw std::runtime_error((folder / "summary.json").string() +
                             ": is not what batch writes: " + error.what());
  }
  return result;
}

std::vector<FarmResult> read_results(const fs::path& farm, const Expectations& expectations) {
  std::vector<FarmResult> results;
  if (fs::is_directory(farm))
    for (const fs::directory_entry& entry : fs::directory_iterator(farm))
      if (fs::exists(entry.path() / "batch.txt") || fs::exists(entry.path() / "summary.json"))
        results.push_back(read_result(entry.path(), expectations));
  if (results.empty())
    throw std::runtime_error(farm.string() + ": holds no results (lcmslam batch CONFIG LOG... --out " +
                             farm.string() + " makes them)");
  std::sort(results.begin(), results.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return results;
}

void put_worst_first(std::vector<FarmResult>& results) {
  const auto of_any = [&](std::optional<double> FarmResult::*ate) {
    return std::any_of(results.begin(), results.end(),
                       [&](const FarmResult& r) { return (r.*ate).has_value(); });
  };
  const bool icp = of_any(&FarmResult::icp), fastslam = of_any(&FarmResult::fastslam);
  const auto order = [&](const FarmResult& r) {
    const bool unmapped = r.odometry && ((icp && !r.icp) || (fastslam && !r.fastslam));
    return std::make_tuple(r.has_summary, r.passed(), !unmapped, -r.badness(), r.name);
  };
  std::sort(results.begin(), results.end(),
            [&](const FarmResult& a, const FarmResult& b) { return order(a) < order(b); });
}

}  // namespace lcmslam
