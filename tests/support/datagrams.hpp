#pragma once
// Datagrams of LCM's UDP multicast, made by hand, and a socket that sends them anywhere.

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace lcmslam::testing {

using Bytes = std::vector<std::uint8_t>;

inline void append(Bytes& bytes, std::uint32_t value, int size) {
  for (int shift = 8 * (size - 1); shift >= 0; shift -= 8)
    bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

inline Bytes bytes_of(const std::string& text) {
  return {text.begin(), text.end()};
}

/// "LC02": a whole message.
inline Bytes whole_datagram(const std::string& channel, const Bytes& data, std::uint32_t sequence = 0) {
  Bytes bytes = bytes_of("LC02");
  append(bytes, sequence, 4);
  bytes.insert(bytes.end(), channel.begin(), channel.end());
  bytes.push_back(0);
  bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

struct FragmentHeader {
  std::uint32_t sequence = 0, message_size = 0, offset = 0;
  std::uint32_t number = 0, count = 1;  // two bytes each on the wire
};

/// "LC03": `rest` is the channel with its end, in fragment 0, and the data.
inline Bytes fragment_datagram(const FragmentHeader& header, const Bytes& rest) {
  Bytes bytes = bytes_of("LC03");
  for (const std::uint32_t value : {header.sequence, header.message_size, header.offset})
    append(bytes, value, 4);
  append(bytes, header.number, 2);
  append(bytes, header.count, 2);
  bytes.insert(bytes.end(), rest.begin(), rest.end());
  return bytes;
}

/// The two datagrams that kill a process that receives with LCM 1.3.1: the second one's offset, added to its
/// size, wraps round to a small number.
inline std::vector<Bytes> killing_datagrams(const std::string& channel) {
  Bytes first = bytes_of(channel);
  first.push_back(0);
  first.resize(first.size() + 100, 'x');
  return {fragment_datagram({7, 1000, 0, 0, 3}, first),
          fragment_datagram({7, 1000, 0xfffffff0, 1, 3}, Bytes(200, 'y'))};
}

class UdpSender {
 public:
  /// `ttl` of multicast; 0 stays on this machine.
  explicit UdpSender(int ttl = 0) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  }
  ~UdpSender() { close(socket_); }
  UdpSender(const UdpSender&) = delete;
  UdpSender& operator=(const UdpSender&) = delete;

  void send(const std::string& address, int port, const Bytes& bytes) const {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    inet_pton(AF_INET, address.c_str(), &to.sin_addr);
    if (sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to) < 0)
      throw std::runtime_error("cannot send to " + address);
  }

 private:
  int socket_;
};

}  // namespace lcmslam::testing
