#pragma once
// Whose packets are taken. A socket of LCM listens to everybody who can reach this machine, whatever the ttl.

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace lcmslam::udpm {

/// Addresses that agree with `address` in the bits of `mask`; both in host byte order.
struct Network {
  std::uint32_t address = 0;
  std::uint32_t mask = 0;
  bool holds(std::uint32_t other) const { return ((address ^ other) & mask) == 0; }
};

/// "10.0.0.5, 10.0.1.0/24". Throws std::invalid_argument that names what is neither address nor network.
std::vector<Network> parse_networks(const std::string& text);

/// LCMSLAM_BUS_ALLOW. An environment variable as LCM_DEFAULT_URL is: the tools that read no configuration
/// must know it too, and launch hands it on to its processes.
std::vector<Network> allowed_networks();

/// IPv4 addresses of this machine's interfaces and 0.0.0.0, in host byte order.
std::vector<std::uint32_t> addresses_of_this_machine();

/// This machine's own packets are always taken, those of the allowed networks too. Without such a list: with
/// ttl=0, which says that the bus is this machine's own, nobody else's; with more everybody's.
class SourceFilter {
 public:
  using Time = std::chrono::steady_clock::time_point;

  SourceFilter(int ttl, std::vector<Network> allowed,
               std::function<std::vector<std::uint32_t>()> own_addresses = addresses_of_this_machine)
      : everybody_(ttl > 0 && allowed.empty()),
        allowed_(std::move(allowed)),
        own_addresses_(std::move(own_addresses)) {}

  /// `address` in host byte order. For one that is unknown this machine's addresses are looked at again, as
  /// an interface may have got another, but not more often than once a second.
  bool takes(std::uint32_t address, Time now);

 private:
  bool everybody_;
  std::vector<Network> allowed_;
  std::function<std::vector<std::uint32_t>()> own_addresses_;
  std::vector<std::uint32_t> own_;
  Time looked_{};
};

}  // namespace lcmslam::udpm
