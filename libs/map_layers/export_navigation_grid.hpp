#pragma once
// The navigation grid as ROS's map_server reads it.

#include <lcmslam/files/part_file.hpp>
#include <lcmslam/map_layers/navigation_grid.hpp>

namespace lcmslam {

/// NAME.pgm and, when that is whole, NAME.yaml, which names it. `name` without an ending. Throws
/// std::runtime_error that names the file and the reason.
void save_navigation_grid(const HeldFolder& folder, const std::string& name, const NavigationGrid& grid);

}  // namespace lcmslam
