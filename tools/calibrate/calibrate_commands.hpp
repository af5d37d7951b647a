#pragma once
// The subcommands of `lcmslam calibrate`.

#include "tools/commands.hpp"

namespace lcmslam {

const std::vector<Command>& calibrate_subcommands();

int calibrate_self_command(int argc, char** argv);

}  // namespace lcmslam
