#pragma once
// Hears the bus without knowing types.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <string>

namespace lcmslam {

class BusListener {
 public:
  using Handler = std::function<void(const std::string& channel, const std::uint8_t* data, std::size_t size)>;

  /// `pattern`: regular expression of channel names, as LCM has it. Throws std::runtime_error when it is
  /// none or the bus cannot be used.
  BusListener(const std::string& lcm_url, const std::string& pattern, Handler handler);
  BusListener(const BusListener&) = delete;
  BusListener& operator=(const BusListener&) = delete;

  /// Handles messages until `stop` says so (asked at least every 50 ms), then those that had come before.
  void run(const std::function<bool()>& stop);

 private:
  lcm::LCM lcm_;
  Handler handler_;
};

}  // namespace lcmslam
