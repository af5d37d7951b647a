#pragma once
// A bus where a test is alone.

#include <iostream>
#include <random>
#include <string>

#include <lcmslam/runtime/private_bus.hpp>

namespace lcmslam {

/// `url`, of LCM's usual port, on a private bus that this process enters before it starts threads. Where the
/// machine forbids that: on the shared one with a random port, and it says so.
inline std::string own_bus(std::string url) {
  if (enter_private_bus()) return url;
  const unsigned port = 20'000 + std::random_device()() % 10'000;
  url.replace(url.find(":7667"), 5, ":" + std::to_string(port));
  std::cerr << "no private network namespace on this machine: tests run on the shared bus " << url << "\n";
  return url;
}

}  // namespace lcmslam
