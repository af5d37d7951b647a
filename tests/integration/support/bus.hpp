#pragma once
// The test's own ear and mouth on the bus.

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <lcmslam/messages/decode.hpp>
#include <lcmslam/runtime/bus.hpp>
#include <lcmslam/status_t.hpp>

namespace lcmslam::integration {

using Bytes = std::vector<std::uint8_t>;

/// Listens to everything from its construction on, in a thread of its own.
class Bus {
 public:
  Bus();
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  void publish(const std::string& channel, const Bytes& bytes);
  template <class M>
  void publish(const std::string& channel, const M& message) {
    publish(channel, encode_message(message));
  }

  /// Messages heard on the channel so far.
  std::size_t count(const std::string& channel) const;
  /// Newest message of the channel; empty before the first.
  Bytes newest(const std::string& channel) const;
  template <class M>
  std::optional<M> newest(const std::string& channel) const {
    const Bytes bytes = newest(channel);
    if (bytes.empty()) return std::nullopt;
    return decode_message<M>(bytes.data(), bytes.size());
  }

  /// Newest STATUS of a process, how many came from that pid so far.
  std::optional<status_t> status(const std::string& process) const;
  std::size_t status_count(const std::string& process, std::int64_t pid) const;
  /// Waits for a STATUS that the predicate accepts.
  bool wait_for_status(const std::string& process, const std::function<bool(const status_t&)>& accepts,
                       double seconds) const;

  /// Waits until no datagram waits in any UDP socket of this network namespace: everybody has taken what
  /// was sent. (Paces a flood without knowing the listeners.)
  void wait_until_taken() const;

 private:
  void on_message(const BusMessage& message);
  void on_status(const status_t& status);

  LcmBus bus_;
  std::unique_ptr<BusReader> reader_;
  mutable std::mutex mutex_;
  std::map<std::string, std::size_t> counts_;
  std::map<std::string, Bytes> newest_;
  std::map<std::string, status_t> statuses_;
  std::map<std::pair<std::string, std::int64_t>, std::size_t> status_counts_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// One of a process's own values; NaN when it has none of that name.
double value_of(const status_t& status, const std::string& name);

}  // namespace lcmslam::integration
