// Any sequence of datagrams through the guard: a source, a size and the bytes of each. What comes out has the
// size that it announced, memory stays within its bounds, and nothing is read or written outside of the
// datagram.

#include <algorithm>
#include <cstdlib>

#include <lcmslam/runtime/udpm/reassembly.hpp>

namespace lcmslam::udpm {
namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

void check(const Packet& packet, const std::vector<std::uint8_t>& datagram) {
  const auto* end = datagram.data() + datagram.size();
  require(packet.data >= datagram.data() && packet.data <= end);
  require(packet.size <= static_cast<std::size_t>(end - packet.data));
  require(packet.message_size <= largest_message && packet.size <= packet.message_size);
  require(packet.offset <= packet.message_size - packet.size);
  require(packet.number < packet.count);
  require(packet.channel.empty() == (packet.number != 0));
  require(packet.channel.size() <= largest_channel_name &&
          packet.channel.find('\0') == std::string_view::npos);
}

}  // namespace
}  // namespace lcmslam::udpm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcmslam;
  using namespace lcmslam::udpm;
  const ReassemblyLimits limits{4096, 8, 3};  // small ones, so that they are reached
  Reassembly reassembly([](const std::string& channel) { return channel != "UNWANTED"; }, limits);
  std::size_t refused = 0, taken = 0;
  reassembly.on_refusal = [&](Refusal why) {
    require(why == Refusal::contradiction || why == Refusal::incomplete);
    ++refused;
  };
  while (size >= 3) {
    const Source source{data[0], static_cast<std::uint16_t>(data[0] / 16)};
    const std::size_t announced = static_cast<std::size_t>(data[1]) << 8 | data[2];
    const std::size_t length = std::min(announced, size - 3);
    const std::vector<std::uint8_t> datagram(data + 3,
                                             data + 3 + length);  // the sanitizer knows where it ends
    data += 3 + length;
    size -= 3 + length;
    const auto parsed = parse_packet(datagram.data(), datagram.size());
    if (!std::holds_alternative<Packet>(parsed)) continue;
    const Packet& packet = std::get<Packet>(parsed);
    check(packet, datagram);
    ++taken;
    if (const auto whole = reassembly.add(source, packet)) {
      require(whole->bytes.size() == packet.message_size);
      require(whole->channel != "UNWANTED" && !whole->channel.empty());
    }
    require(reassembly.waiting_bytes() <= limits.bytes && reassembly.waiting_messages() <= limits.messages);
    require((reassembly.waiting_bytes() == 0) == (reassembly.waiting_messages() == 0));
  }
  require(refused <= taken);
  return 0;
}
