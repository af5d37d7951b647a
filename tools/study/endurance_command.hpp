#pragma once
#include <string>
#include <vector>

namespace lcmslam {

/// lcmslam study --only endurance; 0 only where the last lap costs what the third one did. `config`: empty
/// for that of replay.
int endurance_command(int laps, int seed, std::string config, const std::vector<std::string>& overrides);

}  // namespace lcmslam
