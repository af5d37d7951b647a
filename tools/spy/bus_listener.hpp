#pragma once
// Hears the bus without knowing types.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include <lcmslam/runtime/buffered_reader.hpp>
#include <lcmslam/runtime/bus.hpp>

namespace lcmslam {

class BusListener {
 public:
  using Handler = std::function<void(const std::string& channel, const std::uint8_t* data, std::size_t size)>;

  /// `pattern`: regular expression that matches whole channel names. Throws std::runtime_error when it is
  /// none or the bus cannot be used.
  BusListener(const std::string& lcm_url, const std::string& pattern, Handler handler);
  BusListener(const BusListener&) = delete;
  BusListener& operator=(const BusListener&) = delete;

  /// Handles messages until `stop` says so (asked at least every 50 ms), then those that had come before.
  void run(const std::function<bool()>& stop);

  /// What came from the network and was not taken, and the state of the socket. May be asked by any thread.
  Refusals refusals() const { return reader_->refusals(); }
  SocketState socket() const { return reader_->socket(); }
  /// Messages that came faster than they were handled, and were thrown away.
  std::int64_t dropped() const { return reader_->dropped(); }

 private:
  bool handle(std::chrono::milliseconds wait);

  LcmBus bus_;
  Handler handler_;
  std::unique_ptr<BufferedReader> reader_;
};

}  // namespace lcmslam
