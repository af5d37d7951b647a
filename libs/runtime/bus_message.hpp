#pragma once
// A message as it comes from the bus.

#include <cstdint>
#include <string>
#include <vector>

namespace lcmslam {

struct BusMessage {
  std::string channel;
  std::vector<std::uint8_t> bytes;
};

}  // namespace lcmslam
