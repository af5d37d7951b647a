#pragma once
// The occupancy grid as OctoMap's binary tree (.bt), which RViz, octovis, MoveIt and others read.

#include <lcmslam/files/part_file.hpp>
#include <lcmslam/map_layers/occupancy_grid.hpp>

namespace lcmslam {

/// Free and occupied cells, unknown ones left out; the tree's resolution is the cell's size. Written whole
/// (files/atomic_file.hpp); throws std::runtime_error that names the file and the reason.
void save_octomap(const FilePlace& file, const OccupancyGrid& grid);

}  // namespace lcmslam
