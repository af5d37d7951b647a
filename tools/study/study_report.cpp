#include "tools/study/study_report.hpp"

#include <iostream>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/runtime/version.hpp>

namespace lcmslam {

void write_report(const std::filesystem::path& folder, nlohmann::json report, const std::string& table) {
  std::cout << table << std::endl;
  report["version"] = lcmslam_version;
  write_atomically(folder / "report.json",
                   report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  std::cout << (folder / "report.json").string() << "\n";
}

}  // namespace lcmslam
