#include <lcmslam/runtime/udpm/packet.hpp>

#include <algorithm>

namespace lcmslam::udpm {
namespace {

constexpr std::uint32_t whole_magic = 0x4c433032;     // "LC02"
constexpr std::uint32_t fragment_magic = 0x4c433033;  // "LC03"
constexpr std::size_t whole_header = 8;               // bytes
constexpr std::size_t fragment_header = 20;

std::uint32_t big_endian(const std::uint8_t* bytes, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = (value << 8) | bytes[i];
  return value;
}

/// Takes the channel off the front of the data; false when there is no proper one.
bool take_channel(Packet& packet) {
  const auto* end = std::find(packet.data, packet.data + packet.size, std::uint8_t{0});
  const auto length = static_cast<std::size_t>(end - packet.data);
  if (length == packet.size || length == 0 || length > largest_channel_name) return false;
  packet.channel = {reinterpret_cast<const char*>(packet.data), length};
  packet.data += length + 1;
  packet.size -= length + 1;
  return true;
}

std::variant<Packet, Refusal> parse_whole(Packet packet) {
  if (!take_channel(packet)) return Refusal::bad_channel;
  packet.message_size = packet.size;
  return packet;
}

std::variant<Packet, Refusal> parse_fragment(Packet packet, const std::uint8_t* header) {
  packet.message_size = big_endian(header + 8, 4);
  packet.offset = big_endian(header + 12, 4);
  packet.number = static_cast<std::uint16_t>(big_endian(header + 16, 2));
  packet.count = static_cast<std::uint16_t>(big_endian(header + 18, 2));
  if (packet.message_size > largest_message) return Refusal::too_large;
  if (packet.number >= packet.count || packet.count > packet.message_size) return Refusal::bad_number;
  if (packet.number == 0 && !take_channel(packet)) return Refusal::bad_channel;
  if (packet.size == 0) return Refusal::nothing_carried;
  // Not offset + size > message_size: with 32 bits that sum once wrapped round.
  if (packet.size > packet.message_size || packet.offset > packet.message_size - packet.size)
    return Refusal::beyond_end;
  return packet;
}

}  // namespace

std::variant<Packet, Refusal> parse_packet(const std::uint8_t* bytes, std::size_t size) {
  if (size < 4) return Refusal::cut_short;
  const std::uint32_t magic = big_endian(bytes, 4);
  if (magic != whole_magic && magic != fragment_magic) return Refusal::unknown_magic;
  const std::size_t header = magic == whole_magic ? whole_header : fragment_header;
  if (size < header) return Refusal::cut_short;
  Packet packet;
  packet.sequence = big_endian(bytes + 4, 4);
  packet.data = bytes + header;
  packet.size = size - header;
  return magic == whole_magic ? parse_whole(packet) : parse_fragment(packet, bytes);
}

}  // namespace lcmslam::udpm
