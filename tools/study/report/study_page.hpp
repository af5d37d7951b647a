#pragma once
// The study's report as one page that opens offline.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace lcmslam {

/// `report` (run_experiments) inside the page's bundle of folder `page`, with the pictures of `out`. What is
/// drawn is drawn from that JSON in the browser (report/page/src). Throws std::runtime_error that names the
/// file which is missing.
std::string study_page(nlohmann::json report, const std::filesystem::path& out,
                       const std::filesystem::path& page);

}  // namespace lcmslam
