#pragma once
// The datagrams of LCM's UDP multicast. Every claim that one makes about itself is checked before anybody
// computes with it; LCM 1.3.1 writes outside of its memory where a fragment's offset lies (docs/LCM.md).
//
//   whole message  "LC02"  sequence:4                                              channel\0  data
//   fragment       "LC03"  sequence:4  message_size:4  offset:4  number:2  count:2 [channel\0] data
//
// Numbers are big-endian. Fragment 0 alone names the channel; size and offset count the message's data.

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <variant>

#include <lcmslam/runtime/refusals.hpp>

namespace lcmslam::udpm {

constexpr std::size_t largest_channel_name = 63;   ///< characters, LCM's
constexpr std::size_t largest_message = 16 << 20;  ///< bytes; above the largest image or cloud
constexpr std::size_t largest_datagram = 65'535;   ///< bytes

/// A message or a piece of one, as a view into the datagram. offset + size <= message_size, number < count
/// <= message_size (where there is more than one), and the channel is given exactly where number is 0.
struct Packet {
  std::uint32_t sequence = 0;  ///< of the message, counted by its sender
  std::string_view channel;    ///< 1 to largest_channel_name characters
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;          ///< bytes of data in this datagram
  std::size_t message_size = 0;  ///< bytes of data of the whole message
  std::size_t offset = 0;        ///< of this piece within them
  std::uint16_t number = 0;      ///< of this fragment
  std::uint16_t count = 1;       ///< fragments of the message; 1: this is all of it
};

std::variant<Packet, Refusal> parse_packet(const std::uint8_t* bytes, std::size_t size);

}  // namespace lcmslam::udpm
