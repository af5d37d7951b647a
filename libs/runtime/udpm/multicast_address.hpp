#pragma once
// What a URL of LCM's UDP multicast says: udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152

#include <cstdint>
#include <string>

namespace lcmslam {

/// Address of udpm://GROUP:PORT?...; other providers give none.
struct MulticastAddress {
  std::string group;
  int port = 0;
  int ttl = 0;                      ///< routers that packets may pass, and 0: they stay on this machine
  std::int64_t receive_buffer = 0;  ///< bytes to ask the kernel for; 0: its default
};

/// Throws std::invalid_argument when a udpm URL is not understood; group is empty for other providers.
MulticastAddress multicast_address(const std::string& lcm_url);

}  // namespace lcmslam
