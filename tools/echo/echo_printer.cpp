#include "tools/echo/echo_printer.hpp"

#include <fmt/format.h>

#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/print_message.hpp>
#include <lcmslam/runtime/bus_robot.hpp>
#include "tools/spy/bus_statistics.hpp"

namespace lcmslam {

std::string echo_pattern(const std::string& channels) {
  return is_part_channel(channels) ? channels : "(?:" + channels + ")(?:_PART)?";
}

std::optional<std::string> EchoPrinter::print(const std::string& channel, const std::uint8_t* data,
                                              std::size_t size) {
  if (options_.pieces || !is_part_channel(channel)) return print_whole(channel, data, size);
  try {
    auto part = decode_message<part_t>(data, size);
    if (part_channel(part.channel) != channel) part.channel = without_robot(part.channel);
    if (part_channel(part.channel) != channel) throw DecodeError("part_t: of channel " + part.channel);
    if (assemblers_.size() > 1000) assemblers_.clear();  // garbage must not grow the table for ever
    const auto whole = assemblers_[channel].add(part);
    if (!whole) return std::nullopt;
    return print_whole(whole->channel, whole->bytes.data(), whole->bytes.size());
  } catch (const DecodeError&) {
    return print_whole(channel, data, size);
  }
}

std::string EchoPrinter::print_whole(const std::string& channel, const std::uint8_t* data, std::size_t size) {
  if (options_.csv) return table_.row(channel, options_.types.of(data, size), data, size);
  const auto line = [&](const std::string& text, const std::string& json) {
    return options_.json
               ? fmt::format("{{\"channel\":{},\"size\":{},{}}}\n", json_string(channel), size, json)
               : fmt::format("{}  {}\n", printable(channel), text);
  };
  std::string name;
  try {
    const std::uint64_t fingerprint = message_fingerprint(data, size);
    const MessageType* type = options_.types.find(fingerprint);
    if (type == nullptr)
      return line(fmt::format("unknown type {:016x}, {} bytes", fingerprint, size),
                  fmt::format("\"fingerprint\":\"{:016x}\"", fingerprint));
    name = display_name(*type);
    const MessageValue message =
        read_message(*type, data, size, options_.full ? MessageLimits::none() : MessageLimits());
    if (options_.json)
      return line("", fmt::format("\"type\":\"{}\",\"fields\":{}", name, message_json(message)));
    return line(fmt::format("{}, {} bytes", name, size), "") + print_message(message, 2);
  } catch (const DecodeError& error) {
    return line(fmt::format("does not decode: {} ({} bytes)", printable(error.what()), size),
                fmt::format("\"type\":{},\"error\":{}", name.empty() ? "null" : json_string(name),
                            json_string(error.what())));
  }
}

}  // namespace lcmslam
