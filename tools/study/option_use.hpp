#pragma once
// Which options of `lcmslam study` belong to which study: what a study would not look at is refused, lest its
// figures be taken for those of the settings that were asked for.

#include <optional>
#include <string>
#include <vector>

namespace lcmslam {

struct GivenOptions {
  std::vector<std::string> names;  ///< as in --help: "--seeds", "logs"
  std::size_t seeds = 0;           ///< how many
};

/// The first option that `study` does not use, and those that it does. `study`: one of own_studies(),
/// "report" or "demo".
std::optional<std::string> option_problem(const std::string& study, const GivenOptions& given);

}  // namespace lcmslam
