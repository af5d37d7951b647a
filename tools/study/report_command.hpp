#pragma once
// `lcmslam study --out`: the thesis's experiments and one report.

#include <string>
#include <vector>

namespace lcmslam {

/// Names for --only.
std::vector<std::string> report_names();

/// Exit code: 1 where an experiment failed. Empty `seeds`: those that are usual; `only`: all experiments;
/// `out`: a new folder.
int report_command(std::string out, const std::string& only, const std::string& data, bool quick,
                   std::vector<int> seeds);

}  // namespace lcmslam
