#pragma once
// The demo, live, once for each seed.

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace lcmslam {

struct DemoStudySettings {
  std::vector<int> seeds;
  std::string config, data;  ///< as for the demo; empty: its own
  double seconds = 0;        ///< only the first so many; 0: all
  std::vector<std::string> overrides;
};

/// Prints the errors of all runs that came to their end; 0, 1 where one did not, 130 when it was asked to
/// stop.
int study_demo(const DemoStudySettings& settings);

/// One live run with these arguments, its results in the folder; gives its summary.json. Throws where it
/// fails.
using DemoRun =
    std::function<nlohmann::json(const std::vector<std::string>& arguments, const std::filesystem::path&)>;
int study_demo(const DemoStudySettings& settings, const DemoRun& run);

}  // namespace lcmslam
