#include "tools/study/study_report.hpp"

#include <fstream>
#include <iostream>

#include <lcmslam/runtime/version.hpp>

namespace lcmslam {

void write_report(const std::filesystem::path& folder, nlohmann::json report, const std::string& table) {
  report["version"] = lcmslam_version;
  std::ofstream file(folder / "report.json");
  file << report.dump(2) << "\n";
  if (!file) throw std::runtime_error((folder / "report.json").string() + " cannot be written");
  std::cout << table << "\n" << (folder / "report.json").string() << "\n";
}

}  // namespace lcmslam
