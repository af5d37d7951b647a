#pragma once
// Messages from their fragments, in whatever order and from however many senders they come, with bounds on
// what half messages may take: memory is taken for data that came, never for data that were announced.

#include <functional>
#include <list>
#include <map>
#include <optional>

#include <lcmslam/runtime/bus_message.hpp>
#include <lcmslam/runtime/udpm/packet.hpp>

namespace lcmslam::udpm {

/// Who sent a datagram.
struct Source {
  std::uint32_t address = 0;  ///< IPv4, as the kernel gives it: network byte order
  std::uint16_t port = 0;     ///< the same
  bool operator==(const Source& other) const { return address == other.address && port == other.port; }
};

struct ReassemblyLimits {
  std::size_t bytes = 2 * largest_message;  ///< of all fragments that wait
  std::size_t messages = 256;               ///< that wait for fragments
  std::size_t of_a_sender = 4;              ///< LCM sends one after the other; the network may swap some
};

/// As LCMSLAM_BUS_MEMORY says: MiB of half messages, 32 without it; the number of messages grows with it.
/// Throws std::invalid_argument for what is not 16 to 4096.
ReassemblyLimits reassembly_limits();

class Reassembly {
 public:
  /// `wanted` says whether a channel's messages are to be put together at all.
  explicit Reassembly(std::function<bool(const std::string&)> wanted, ReassemblyLimits limits = {})
      : wanted_(std::move(wanted)), limits_(limits) {}

  /// The whole message when this was its last missing fragment. Where bounds are reached the messages that
  /// wait longest are given up.
  std::optional<BusMessage> add(const Source& source, const Packet& packet);

  /// Of fragments that wait, with what it takes to keep them.
  std::size_t waiting_bytes() const { return bytes_; }
  std::size_t waiting_messages() const { return waiting_.size(); }

  /// Called for every message that is given up.
  std::function<void(Refusal)> on_refusal = [](Refusal) {};

 private:
  struct Fragment {
    std::size_t offset = 0;
    std::vector<std::uint8_t> data;
  };
  struct Waiting {
    Source source;
    std::uint32_t sequence = 0;
    std::size_t message_size = 0;
    std::uint16_t count = 0;
    bool unwanted = false;  // its fragments are only counted, so that the last one ends it
    std::string channel{};
    std::map<std::uint16_t, Fragment> fragments{};  // by number
  };
  using Place = std::list<Waiting>::iterator;

  Place find_or_begin(const Source& source, const Packet& packet);
  void keep(Waiting& waiting, const Packet& packet);
  void drop_data(Waiting& waiting);
  std::optional<BusMessage> join(const Waiting& whole) const;
  Waiting remove(Place place);
  void give_up(Place place, Refusal why);
  static std::size_t cost(const Fragment& fragment);

  std::function<bool(const std::string&)> wanted_;
  ReassemblyLimits limits_;
  std::list<Waiting> waiting_;  // oldest first
  std::size_t bytes_ = 0;
};

}  // namespace lcmslam::udpm
