#pragma once
// The only way a message's bytes become a message.

#include <lcmslam/messages/schema.hpp>

namespace lcmslam {

/// Throws DecodeError when the bytes are not exactly one message of type M.
template <class M>
M decode_message(const std::uint8_t* data, std::size_t size) {
  static const MessageType* type = MessageType::find(static_cast<std::uint64_t>(M::getHash()));
  if (type == nullptr) throw DecodeError(std::string(M::getTypeName()) + " has no definition in lcmtypes/");
  check_layout(*type, data, size);
  const auto of_today = completed(*type, data, size);
  M message;
  const int read = of_today ? message.decode(of_today->data(), 0, static_cast<int>(of_today->size()))
                            : message.decode(data, 0, static_cast<int>(size));
  if (read < 0) throw DecodeError(type->name + " does not decode");
  return message;
}

template <class M>
std::vector<std::uint8_t> encode_message(const M& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace lcmslam
