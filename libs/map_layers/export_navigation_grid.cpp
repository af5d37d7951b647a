#include <lcmslam/map_layers/export_navigation_grid.hpp>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

// map_server's trinary mode: darkness is the probability of being occupied, 205 lies between its thresholds.
char grey(std::int8_t cell) {
  const int value = cell == NavigationGrid::occupied ? 0 : cell == NavigationGrid::free ? 254 : 205;
  return static_cast<char>(value);
}

// The image's first row is the map's last: y points up.
std::string pgm(const cv::Mat_<std::int8_t>& cells) {
  std::string bytes = "P5\n" + std::to_string(cells.cols) + " " + std::to_string(cells.rows) + "\n255\n";
  for (int y = cells.rows - 1; y >= 0; --y)
    for (int x = 0; x < cells.cols; ++x) bytes += grey(cells(y, x));
  return bytes;
}

std::string yaml(const std::string& image, const NavigationGrid& grid) {
  return "image: \"" + image + "\"\nmode: trinary\nresolution: " + number_text(grid.cell_size) +
         "\norigin: [" + number_text(grid.origin.x()) + ", " + number_text(grid.origin.y()) +
         ", 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
}

}  // namespace

void save_navigation_grid(const HeldFolder& folder, const std::string& name, const NavigationGrid& grid) {
  check_name(name);
  write_atomically({folder, name + ".pgm"}, pgm(grid.cells));
  write_atomically({folder, name + ".yaml"}, yaml(name + ".pgm", grid));
}

}  // namespace lcmslam
