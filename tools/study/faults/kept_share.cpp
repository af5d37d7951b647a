#include "tools/study/faults/kept_share.hpp"

#include <algorithm>

#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/map_store/map_export.hpp>

namespace lcmslam {

std::optional<double> kept_share(const std::filesystem::path& before, const std::filesystem::path& folder,
                                 const std::string& map) {
  if (!std::filesystem::exists(before)) return std::nullopt;
  const ColouredCloud old = load_pcd(before);
  if (old.points.empty()) return std::nullopt;
  double best = 0;
  const std::string stem = map.substr(0, map.find('_'));
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (entry.path().extension() != ".pcd" || name.compare(0, stem.size(), stem) != 0) continue;
    const ColouredCloud now = load_pcd(entry.path());
    if (now.points.empty()) continue;
    const KdTree tree(now.points);
    std::size_t kept = 0;
    for (const Eigen::Vector3f& p : old.points) kept += tree.nearest(p, 0.1f).index >= 0 ? 1 : 0;
    best = std::max(best, static_cast<double>(kept) / static_cast<double>(old.points.size()));
  }
  return best;
}

}  // namespace lcmslam
