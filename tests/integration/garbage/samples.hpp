#pragma once
// Valid messages of every channel: a short simulated drive, put through the nodes in memory.

#include <string>
#include <vector>

#include <lcmslam/geometry/transform.hpp>
#include "tests/integration/support/bus.hpp"

namespace lcmslam::integration {

struct Sample {
  std::string channel;
  Bytes bytes;
};

/// In the order in which a running graph would publish them; every channel of a graph occurs, with
/// `seconds` of the simulated kitchen.
std::vector<Sample> record_samples(double seconds);

/// The same at another time.
Sample later(Sample sample, Utime us);

}  // namespace lcmslam::integration
