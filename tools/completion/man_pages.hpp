#pragma once
// Manual pages (section 1), made from the commands' own descriptions as the completion is.

#include <filesystem>
#include <map>
#include <string>

namespace lcmslam {

/// Name of the file -> its text: lcmslam.1, and lcmslam-COMMAND.1 and lcmslam-log-SUBCOMMAND.1 for each.
std::map<std::string, std::string> man_pages();

/// Writes them into a folder, which is made. Throws std::runtime_error, naming the file.
void write_man_pages(const std::filesystem::path& folder);

}  // namespace lcmslam
