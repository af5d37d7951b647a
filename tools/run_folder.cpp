#include "tools/run_folder.hpp"

#include <ctime>
#include <stdexcept>

namespace lcmslam {
namespace {

bool is_left_by_a_run(const std::string& name) {
  const auto ends_with = [&](const std::string& end) {
    return name.size() >= end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0;
  };
  return name == "batch.lcmlog" || name == "summary.json" || ends_with("_map.ply") || ends_with("_map.pcd");
}

}  // namespace

void check_run_folder(const std::filesystem::path& folder, bool force) {
  if (force || !std::filesystem::is_directory(folder)) return;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (is_left_by_a_run(entry.path().filename()))
      throw std::runtime_error(folder.string() + ": holds the results of another run (" +
                               entry.path().filename().string() +
                               "); name another folder with --out, or --force overwrites them");
}

std::filesystem::path nearest_folder(const std::filesystem::path& folder) {
  std::filesystem::path nearest = std::filesystem::absolute(folder);
  std::error_code ignored;
  while (nearest != nearest.root_path() && !std::filesystem::is_directory(nearest, ignored))
    nearest = nearest.parent_path();
  return nearest;
}

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
