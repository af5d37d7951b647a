#pragma once
#include <string>

namespace lcmslam {

/// `lcmslam launch --status, --stop, --restart NAME`: says the request to the launch that runs, of this robot
/// where one is named. Gives the exit code: 1 refused, 2 which one?, 3 none runs.
int control_launch(const std::string& request, const std::string& robot);

}  // namespace lcmslam
