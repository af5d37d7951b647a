#pragma once
#include <filesystem>
#include <string>

namespace lcmslam {

/// Makes and gives out/NAME-YYYYMMDD-HHMMSS in the current folder; a number is added when it exists.
std::filesystem::path new_run_folder(const std::string& name);

}  // namespace lcmslam
