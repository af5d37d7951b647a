#include "tools/study/demo_study.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <thread>

#include <lcmslam/evaluation/table.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/launch/graph.hpp"
#include "tools/launch/supervisor.hpp"
#include "tools/output_file.hpp"
#include "tools/run_folder.hpp"
#include "tools/study/measures.hpp"

namespace lcmslam {
namespace {

constexpr std::chrono::milliseconds demo_poll_period(20);
constexpr int stopped_by_a_signal = 130;  // exit code, as the demo's

const char* const path_names[] = {"odometry", "fastslam", "icp"};

/// One live run; its summary.json.
nlohmann::json run_demo(const std::vector<std::string>& arguments, const std::filesystem::path& folder) {
  ProcessSpec spec;
  spec.name = "demo";
  spec.arguments = {program_folder() / "lcmslam", "demo", "--headless", "--out", folder};
  spec.arguments.insert(spec.arguments.end(), arguments.begin(), arguments.end());
  spec.log = folder.string() + ".txt";
  spec.restart = false;
  Supervisor supervisor;  // it ends the run with the study
  supervisor.start(spec);
  while (!supervisor.all_stopped()) {
    throw_when_stopped();
    supervisor.poll();
    std::this_thread::sleep_for(demo_poll_period);
  }
  if (supervisor.processes().front().failed)
    throw std::runtime_error("the run failed; see " + spec.log.string());
  std::ifstream file(folder / "summary.json");
  return nlohmann::json::parse(file);
}

/// Nothing for a recording without truth, or where too little was mapped.
std::optional<double> ate(const nlohmann::json& summary, const std::string& path) {
  const nlohmann::json::json_pointer place("/paths/" + path + "/ate/translation_rmse_m");
  if (!summary.contains(place)) return std::nullopt;
  return summary.at(place).get<double>();
}

}  // namespace

int study_demo(const DemoStudySettings& settings) {
  return study_demo(settings, run_demo);
}

int study_demo(const DemoStudySettings& settings, const DemoRun& run) {
  const std::filesystem::path folder = new_run_folder("study");
  Table table({"seed", "frames", "odometry ATE m", "fastslam ATE m", "icp ATE m", "icp frames", "lost"});
  std::map<std::string, std::vector<double>> errors;
  std::vector<int> failed;
  for (const int seed : settings.seeds) {
    if (stop_requested()) break;
    std::vector<std::string> arguments = {"--seed", std::to_string(seed)};
    if (!settings.config.empty()) arguments.insert(arguments.end(), {"--config", settings.config});
    if (!settings.data.empty()) arguments.insert(arguments.end(), {"--data", settings.data});
    if (settings.seconds > 0)
      arguments.insert(arguments.end(), {"--seconds", std::to_string(settings.seconds)});
    for (const auto& value : settings.overrides) arguments.insert(arguments.end(), {"--set", value});
    nlohmann::json summary;
    try {
      summary = run(arguments, folder / ("seed-" + std::to_string(seed)));
    } catch (const std::exception& problem) {
      if (stop_requested()) break;
      failed.push_back(seed);
      std::cout << "seed " << seed << ": " << problem.what() << std::endl;
      continue;
    }
    std::vector<std::string> row = {std::to_string(seed),
                                    fmt::format("{:.0f}", summary.at("frames").get<double>())};
    for (const char* name : path_names) {
      const std::optional<double> error = ate(summary, name);
      if (error) errors[name].push_back(*error);
      row.push_back(error ? fixed_number(*error, 4) : "-");
    }
    const auto& paths = summary.at("paths");
    row.push_back(std::to_string(paths.at("icp").at("poses").get<int>()));
    row.push_back(
        std::to_string(paths.at("icp").at("lost").get<int>() + paths.at("fastslam").at("lost").get<int>()));
    table.add(row);
    std::cout << "seed " << seed << ": done" << std::endl;
  }
  for (const bool worst : {false, true}) {
    std::vector<std::string> row = {worst ? "worst" : "median", ""};
    for (const char* name : path_names) {
      const auto& values = errors[name];
      row.push_back(
          values.empty()
              ? "-"
              : fixed_number(worst ? *std::max_element(values.begin(), values.end()) : median(values), 4));
    }
    row.insert(row.end(), {"", ""});
    table.add(row);
  }
  std::cout << table.text();
  for (const int seed : failed) std::cout << "seed " << seed << " failed, and is in no row\n";
  if (stop_requested()) std::cout << "stopped by a signal: the other seeds are in no row\n";
  std::cout << "\nruns: " << folder.string() << "\n";
  if (stop_requested()) return stopped_by_a_signal;
  return failed.empty() ? 0 : 1;
}

}  // namespace lcmslam
