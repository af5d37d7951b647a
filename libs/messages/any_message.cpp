#include <lcmslam/messages/any_message.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t wire_word = 8;  // bytes; on the wire: fingerprint, utime, seq, sender

std::int64_t read_word(const std::uint8_t* at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < wire_word; ++i) value = (value << 8) | at[i];
  return static_cast<std::int64_t>(value);
}

bool is_word(const MessageType& type, std::size_t index, const char* name) {
  return type.fields.size() > index && type.fields[index].name == name &&
         type.fields[index].kind == MessageField::Kind::int64 && type.fields[index].dimensions.empty();
}

bool is_numbered(const MessageType& type) {
  return is_word(type, 0, "utime") && is_word(type, 1, "seq") && is_word(type, 2, "sender");
}

}  // namespace

AnyMessage identify(const std::uint8_t* data, std::size_t size) {
  if (size < wire_word) throw DecodeError(std::to_string(size) + " bytes are no message");
  const MessageType* type = MessageType::find(static_cast<std::uint64_t>(read_word(data)));
  if (type == nullptr) throw DecodeError("a message of a type that is not known");
  check_layout(*type, data, size);
  AnyMessage message;
  message.type = type;
  if (is_word(*type, 0, "utime")) message.utime = read_word(data + wire_word);
  if (is_numbered(*type)) message.origin = {read_word(data + 2 * wire_word), read_word(data + 3 * wire_word)};
  return message;
}

void renumber(std::vector<std::uint8_t>& message, const AnyMessage& is, std::int64_t seq) {
  if (!is_numbered(*is.type)) return;
  auto value = static_cast<std::uint64_t>(seq);
  for (std::size_t i = 0; i < wire_word; ++i, value >>= 8)
    message[3 * wire_word - 1 - i] = static_cast<std::uint8_t>(value & 0xff);
}

}  // namespace lcmslam
