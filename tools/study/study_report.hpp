#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace lcmslam {

/// report.json of a study of its own, and its table on the screen.
void write_report(const std::filesystem::path& folder, nlohmann::json report, const std::string& table);

}  // namespace lcmslam
