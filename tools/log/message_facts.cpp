#include "tools/log/message_facts.hpp"

#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/wire_reader.hpp>

namespace lcmslam {
namespace {

/// The value of the n-th field if it and all before it are int64.
std::optional<std::int64_t> leading_integer(const MessageType* type, std::size_t n, const std::string& name,
                                            const std::uint8_t* data, std::size_t size) {
  if (type == nullptr || type->fields.size() <= n || size < 8 * (n + 2)) return std::nullopt;
  for (std::size_t i = 0; i <= n; ++i)
    if (type->fields[i].kind != MessageField::Kind::int64 || !type->fields[i].dimensions.empty())
      return std::nullopt;
  if (type->fields[n].name != name) return std::nullopt;
  return WireReader(data + 8 * (n + 1), 8).integer(8, name);
}

}  // namespace

Wholeness check_message(std::string_view, const std::uint8_t* data, std::size_t size) {
  return check_message_of(message_type(data, size), data, size);
}

Wholeness check_message_of(const MessageType* type, const std::uint8_t* data, std::size_t size) {
  if (type == nullptr) return Wholeness::undecided;
  try {
    check_layout(*type, data, size);
  } catch (const DecodeError&) {
    return Wholeness::damaged;
  }
  return Wholeness::whole;
}

std::optional<std::uint64_t> fingerprint(const std::uint8_t* data, std::size_t size) {
  if (size < 8) return std::nullopt;
  return static_cast<std::uint64_t>(WireReader(data, size).integer(8, "fingerprint"));
}

const MessageType* message_type(const std::uint8_t* data, std::size_t size) {
  const auto found = fingerprint(data, size);
  return found ? MessageType::find(*found) : nullptr;
}

std::optional<Utime> message_utime(const std::uint8_t* data, std::size_t size) {
  return message_utime_of(message_type(data, size), data, size);
}

std::optional<Utime> message_utime_of(const MessageType* type, const std::uint8_t* data, std::size_t size) {
  return leading_integer(type, 0, "utime", data, size);
}

Origin message_origin(const std::uint8_t* data, std::size_t size) {
  static const auto images = static_cast<std::uint64_t>(images_t::getHash());
  const MessageType* type = message_type(data, size);
  if (type != nullptr && type->fingerprint == images) {
    try {
      return origin(decode_message<images_t>(data, size));
    } catch (const DecodeError&) {
      return {};
    }
  }
  const auto seq = leading_integer(type, 1, "seq", data, size);
  const auto sender = leading_integer(type, 2, "sender", data, size);
  return seq && sender ? Origin{*seq, *sender} : Origin{};
}

}  // namespace lcmslam
