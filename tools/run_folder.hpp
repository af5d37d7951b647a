#pragma once
#include <filesystem>
#include <string>

namespace lcmslam {

/// Throws std::runtime_error when the folder that a user named holds what another run has left there (its
/// logs, maps or summary), unless `force` is given.
void check_run_folder(const std::filesystem::path& folder, bool force);

/// This folder, or the nearest above it that is there: where it would be made.
std::filesystem::path nearest_folder(const std::filesystem::path& folder);

/// Makes and gives out/NAME-YYYYMMDD-HHMMSS in the current folder; a number is added when it exists.
std::filesystem::path new_run_folder(const std::string& name);

}  // namespace lcmslam
