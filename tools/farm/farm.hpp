#pragma once
// Many logs through batch, each in a process of its own. What is done already, by the same key, is not run
// again; what was stopped in the middle is.

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "tools/farm/farm_jobs.hpp"
#include "tools/farm/farm_results.hpp"

namespace lcmslam {

struct FarmOptions {
  std::filesystem::path folder;  ///< gets a folder a job
  std::vector<FarmJob> jobs;
  int at_a_time = 1;
  bool force = false;  ///< overwrite results of runs that are not of a farm
  Expectations expectations;
  std::function<std::string(const FarmJob&)> key;
  /// Program first; it writes `folder`/summary.json last, with the key.
  std::function<std::vector<std::string>(const FarmJob&, const std::filesystem::path& folder,
                                         const std::string& key)>
      command;
};

/// Runs what is not done, with a line for each job that ends. Gives the results of all jobs, in their order.
/// Throws std::runtime_error when it is stopped (SIGINT, SIGTERM): the processes are stopped then; and,
/// before anything runs, where a job's folder holds the results of a run that is not of a farm.
std::vector<FarmResult> run_farm(const FarmOptions& options, std::ostream& out);

/// 0: all passed; 1: some did not reach what was expected; 2: some have no result.
int exit_code_of(const std::vector<FarmResult>& results);

}  // namespace lcmslam
