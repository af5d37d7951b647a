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
  M message;
  // Without LCM's own look at the fingerprint: check_layout() knows former ones, too.
  constexpr int at = sizeof(std::uint64_t);
  if (message._decodeNoHash(data, at, static_cast<int>(size) - at) < 0)
    throw DecodeError(type->name + " does not decode");
  return message;
}

template <class M>
std::vector<std::uint8_t> encode_message(const M& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace lcmslam
