#pragma once
// The demo, live, once for each seed.

#include <string>
#include <vector>

namespace lcmslam {

struct DemoStudySettings {
  std::vector<int> seeds;
  std::string config, data;  ///< as for the demo; empty: its own
  double seconds = 0;        ///< only the first so many; 0: all
  std::vector<std::string> overrides;
};

/// Prints the errors of all runs; 0. Throws std::runtime_error for a run that fails.
int study_demo(const DemoStudySettings& settings);

}  // namespace lcmslam
