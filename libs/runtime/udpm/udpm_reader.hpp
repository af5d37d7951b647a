#pragma once
// Reads LCM's UDP multicast by itself: LCM 1.3.1 trusts every datagram from everywhere.

#include <mutex>

#include <lcmslam/runtime/bus_reader.hpp>
#include <lcmslam/runtime/udpm/multicast_address.hpp>
#include <lcmslam/runtime/udpm/reassembly.hpp>
#include <lcmslam/runtime/udpm/source_filter.hpp>

namespace lcmslam::udpm {

class UdpmReader : public BusReader {
 public:
  /// Joins the group. Throws std::runtime_error when that cannot be done.
  UdpmReader(const MulticastAddress& address, ChannelSet channels, SourceFilter filter);
  ~UdpmReader() override;
  UdpmReader(const UdpmReader&) = delete;
  UdpmReader& operator=(const UdpmReader&) = delete;

  bool read(BusMessage& message, std::chrono::milliseconds wait) override;
  Refusals refusals() const override;
  SocketState socket() const override;

 private:
  struct Datagram {
    Source source;
    std::uint32_t destination = 0;  // network byte order
    std::size_t size = 0;
  };
  void open(const MulticastAddress& address);
  bool change_membership(int option) const;
  void join_again();
  bool receive(Datagram& datagram);
  std::optional<BusMessage> take(const Datagram& datagram);
  std::optional<BusMessage> refuse(Refusal why, const Datagram& datagram);
  void count(Refusal why);

  std::uint32_t group_;  // network byte order
  ChannelSet channels_;
  SourceFilter filter_;
  Reassembly reassembly_;
  std::vector<std::uint8_t> buffer_;
  int socket_ = -1;
  std::chrono::steady_clock::time_point next_join_{};
  mutable std::mutex mutex_;  // for what follows
  Refusals refusals_;
};

}  // namespace lcmslam::udpm
