#pragma once
// Any message as a tree of values, read along its definition: for tools that know no type at compile time.

#include <cstdint>
#include <string>
#include <vector>

#include <lcmslam/messages/origin.hpp>
#include <lcmslam/messages/schema.hpp>

namespace lcmslam {

/// A member, an array's element, or the whole message.
struct MessageValue {
  enum class Kind { integer, real32, real64, boolean, text, bytes, array, record };
  Kind kind = Kind::record;
  std::string name;                 ///< of the member; empty for the message and for elements
  std::string type_name;            ///< as in the definition; of arrays that of their elements
  std::int64_t integer = 0;         ///< integer, boolean (0 or 1)
  double real = 0;                  ///< real32, real64
  std::string text;                 ///< text and bytes, perhaps abridged
  std::vector<MessageValue> items;  ///< of an array its elements, perhaps abridged; of a record its members
  std::size_t length = 0;           ///< of text, bytes (in bytes) and arrays in the message
};

/// Longer arrays and texts are abridged to so many of their first elements.
struct MessageLimits {
  std::size_t elements = 6;  ///< of an array of numbers or texts
  std::size_t records = 3;   ///< of an array of arrays or of nested types
  std::size_t text = 120;    ///< bytes
  std::size_t bytes = 8;
  static MessageLimits none();
};

/// Throws DecodeError unless the bytes are exactly one message of this type (check_layout).
MessageValue read_message(const MessageType& type, const std::uint8_t* data, std::size_t size,
                          const MessageLimits& limits = {});

/// A member of a record by its name, nullptr when there is none.
const MessageValue* member(const MessageValue& record, const std::string& name);

/// Who sent the message and its number, by the members of that name or images_t's metadata (read with at
/// least 8 bytes and 16 records).
Origin origin(const MessageValue& message);

}  // namespace lcmslam
