#include "tools/farm/expectations.hpp"

#include <fmt/format.h>
#include <fnmatch.h>
#include <nlohmann/json.hpp>
#include <optional>

#include <lcmslam/configuration/read_settings.hpp>

namespace lcmslam {
namespace {

RunBars read_bars(const ConfigNode& node, const RunBars& defaults) {
  return {read_settings(node.section("icp"), defaults.icp),
          read_settings(node.section("fastslam"), defaults.fastslam),
          read_settings(node.section("odometry"), defaults.odometry)};
}

/// The number that a path's entry in summary.json has there; none: there is no truth, or no path.
std::optional<double> number_at(const nlohmann::json& path, const char* pointer) {
  const nlohmann::json::json_pointer place(pointer);
  if (!path.is_object() || !path.contains(place) || !path[place].is_number()) return std::nullopt;
  return path[place].get<double>();
}

void compare(const char* path_name, const nlohmann::json& path, const PathBars& bars,
             std::vector<std::string>& failures) {
  struct Bar {
    const char* what;
    const char* pointer;
    double bar;
    bool at_least;
  };
  for (const Bar& b :
       {Bar{"ate", "/ate/translation_rmse_m", bars.ate, false},
        Bar{"rpe", "/rpe_per_second/translation_rmse_m", bars.rpe, false},
        Bar{"tracked", "/tracked_fraction", bars.tracked, true}, Bar{"lost", "/lost", bars.lost, false}}) {
    if (b.bar < 0) continue;
    const auto value = number_at(path, b.pointer);
    if (!value)
      failures.push_back(
          fmt::format("{}.{} is not known: {}", path_name, b.what,
                      path.value("truth_problem", "the log has no truth, or nothing was mapped")));
    else if (b.at_least ? *value < b.bar : !(*value <= b.bar))
      failures.push_back(fmt::format("{}.{} is {:.4g}, expected {} {:.4g}", path_name, b.what, *value,
                                     b.at_least ? "at least" : "at most", b.bar));
  }
}

}  // namespace

Expectations::Expectations(const std::filesystem::path& file) {
  const ConfigNode config = ConfigNode::load(file);
  all_ = read_bars(config, {});
  const ConfigNode logs = config.section("logs");
  for (const std::string& pattern : logs.keys()) {
    some_.emplace_back(pattern, logs.section(pattern));
    read_bars(some_.back().second, {});
  }
  config.finish();
}

RunBars Expectations::bars_of(const std::string& name) const {
  RunBars bars = all_;
  for (const auto& [pattern, node] : some_)
    if (fnmatch(pattern.c_str(), name.c_str(), 0) == 0) bars = read_bars(node, bars);
  return bars;
}

std::vector<std::string> Expectations::failures(const std::string& name,
                                                const nlohmann::json& summary) const {
  std::vector<std::string> failures;
  for (const nlohmann::json& event : summary.value("events", nlohmann::json::array()))
    failures.push_back(event.get<std::string>());
  const nlohmann::json paths = summary.value("paths", nlohmann::json::object());
  const auto path = [&](const char* key) { return paths.value(key, nlohmann::json::object()); };
  const RunBars bars = bars_of(name);
  compare("icp", path("icp"), bars.icp, failures);
  compare("fastslam", path("fastslam"), bars.fastslam, failures);
  compare("odometry", path("odometry"), bars.odometry, failures);
  return failures;
}

}  // namespace lcmslam
