#include <lcmslam/map_layers/octomap/export_octomap.hpp>

#define OCTOMAP_NODEBUGOUT  // its words are not for a user's screen
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

/// As OctoMap's writeBinary, which says " done." on stderr.
std::string bytes_of(const octomap::OcTree& tree) {
  std::ostringstream bytes;
  bytes.imbue(std::locale::classic());  // the header is text
  bytes << "# Octomap OcTree binary file\n"
           "# (feel free to add / change comments, but leave the first line as it is!)\n#\nid "
        << tree.getTreeType() << "\nsize " << tree.size() << "\nres " << tree.getResolution() << "\ndata\n";
  tree.writeBinaryData(bytes);
  return bytes ? bytes.str() : "";
}

}  // namespace

void save_octomap(const FilePlace& file, const OccupancyGrid& grid) {
  octomap::OcTree tree = tree_of(grid, file.path().string());
  tree.toMaxLikelihood();
  tree.prune();
  const std::string bytes = bytes_of(tree);
  if (bytes.empty()) throw std::runtime_error(file.path().string() + ": OctoMap cannot write it");
  write_atomically(file, bytes);
}

}  // namespace lcmslam
