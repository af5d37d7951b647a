#pragma once
// What a configured graph puts on the bus.

#include <cstddef>
#include <string>
#include <vector>

namespace lcmslam {

/// A graph's images: far larger than all of its other messages, which stay under 100 kB.
struct GraphTraffic {
  std::size_t largest = 300'000;  ///< bytes: VGA colour with depth
  double rate = 30;               ///< Hz; measured ones between 1 and 200, whatever the stamps say
  std::string origin = "assumed: VGA with depth";
  std::string depths;               ///< the depth images in words; empty where none were seen
  std::vector<std::string> doubts;  ///< what looks wrong with images and calibration (rgbd/plausibility.hpp)
};

/// Measured on the first images of the configuration's own source, with half as much again for later
/// ones; assumed where the images come from elsewhere. Throws ConfigError, and what opening the source
/// throws.
GraphTraffic graph_traffic(const std::string& config, const std::vector<std::string>& overrides);

}  // namespace lcmslam
