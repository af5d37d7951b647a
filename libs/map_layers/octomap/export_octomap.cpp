#include <lcmslam/map_layers/octomap/export_octomap.hpp>

#include <octomap/octomap.h>

#include <locale>
#include <sstream>
#include <stdexcept>

#include <lcmslam/files/atomic_file.hpp>

namespace lcmslam {
namespace {

constexpr int keys = 1 << 15;  // of OctoMap on either side of the origin

octomap::OcTree tree_of(const OccupancyGrid& grid, const std::string& file) {
  octomap::OcTree tree(grid.settings().cell_size);
  BlockLogOdds cells;
  for (const Eigen::Vector3i& block : grid.blocks()) {
    if (block.cwiseAbs().maxCoeff() >= keys / block_side)
      throw std::runtime_error(file +
                               ": OctoMap holds 32768 cells on either side of the origin; the map is "
                               "larger");
    grid.load(block, cells);
    for (int i = 0; i < block_cells; ++i) {
      const LogOdds value = cells[static_cast<std::size_t>(i)];
      if (value == unknown_log_odds) continue;
      const Eigen::Vector3i cell = cell_at(block, i) + Eigen::Vector3i::Constant(keys);
      const octomap::OcTreeKey key(static_cast<octomap::key_type>(cell.x()),
                                   static_cast<octomap::key_type>(cell.y()),
                                   static_cast<octomap::key_type>(cell.z()));
      tree.updateNode(key, value > 0, true);
    }
  }
  tree.updateInnerOccupancy();
  return tree;
}

}  // namespace

void save_octomap(const FilePlace& file, const OccupancyGrid& grid) {
  octomap::OcTree tree = tree_of(grid, file.path().string());
  tree.toMaxLikelihood();
  tree.prune();
  std::ostringstream bytes;
  bytes.imbue(std::locale::classic());  // its header is text
  if (!tree.writeBinaryConst(bytes))
    throw std::runtime_error(file.path().string() + ": OctoMap cannot write it");
  write_atomically(file, bytes.str());
}

}  // namespace lcmslam
