#include "tools/run_folder.hpp"

#include <ctime>

namespace lcmslam {

std::filesystem::path new_run_folder(const std::string& name) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", &local);
  const std::filesystem::path base = std::filesystem::absolute("out") / (name + "-" + stamp);
  std::filesystem::path folder = base;
  for (int i = 2; std::filesystem::exists(folder); ++i) folder = base.string() + "-" + std::to_string(i);
  std::filesystem::create_directories(folder);
  return folder;
}

}  // namespace lcmslam
