#pragma once
// The bus that a URL names, to send and to listen. Messages go out through LCM. What comes over UDP multicast
// is read by our own reader (udpm/), since LCM's can be killed by a single datagram; other providers by LCM.

#include <lcm/lcm-cpp.hpp>
#include <memory>

#include <lcmslam/runtime/bus_reader.hpp>

namespace lcmslam {

class LcmBus {
 public:
  /// Throws std::invalid_argument when the URL, LCMSLAM_BUS_ALLOW, _KEY or _MEMORY, or LCMSLAM_ROBOT is not
  /// understood, and for mpudpm.
  explicit LcmBus(const std::string& lcm_url);

  /// Whether messages can be sent and received. A tcpq bus without its server is "good" but has no
  /// descriptor, and LCM ends the process when it is asked to wait for it.
  bool usable();

  /// To send. Over UDP multicast nothing is to be subscribed with it: that would open LCM's own receive path.
  lcm::LCM& lcm() { return lcm_; }

  /// Hears what comes from now on; with LCMSLAM_ROBOT that robot's channels, without its name. Throws
  /// std::runtime_error when that is not possible. The bus must outlive the reader.
  std::unique_ptr<BusReader> listen(const ChannelSet& channels);

 private:
  std::string url_;
  lcm::LCM lcm_;
};

}  // namespace lcmslam
