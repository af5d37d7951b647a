#pragma once
// Experiments one after the other (each takes both cores itself), into one folder with one report.

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/study/report/experiment.hpp"

namespace lcmslam {

struct StudyRunSettings {
  std::filesystem::path out;   ///< gets report.json, index.html and pictures/; made where it is missing
  std::filesystem::path data;  ///< of real recordings; empty: none
  bool quick = false;
  std::vector<int> seeds;
  std::filesystem::path page;  ///< the page's bundle, share/lcmslam/study
  /// `done` of `all` experiments, `part` of 0 to 1 of the one at hand, after so many seconds.
  std::function<void(const std::string& name, std::size_t done, double part, std::size_t all, double seconds)>
      progress = [](auto&&...) {};
  /// An experiment has ended; `error` is empty where it went well.
  std::function<void(const std::string& name, const std::string& error)> ended = [](auto&&...) {};
};

/// All experiments, in the thesis's order: what the program has.
std::vector<Experiment> study_experiments();

/// Those with this name, or all for an empty one. Throws std::invalid_argument that lists the names.
std::vector<Experiment> experiments_named(std::vector<Experiment> experiments, const std::string& name);

/// report.json's content. An experiment that throws is there with status "failed" and its message, and the
/// rest is run. Two runs with the same settings differ in `timing` and `memory` of experiments alone.
nlohmann::json run_experiments(const std::vector<Experiment>& experiments, const StudyRunSettings& settings);

/// Runs, writes report.json and index.html atomically; true when no experiment failed. Throws
/// std::runtime_error where nothing can be written.
bool run_study(const std::vector<Experiment>& experiments, const StudyRunSettings& settings);

}  // namespace lcmslam
