#pragma once
// The message definitions as data. LCM's generated decoders trust the lengths in a message: they read
// past its end and allocate what it asks for. So every message is first walked along its definition,
// here, and only what fits exactly is decoded.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace lcmslam {

/// A message that is not what it claims to be; says what is wrong with it.
class DecodeError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct MessageType;

/// One member of a message: `type name[dimension]...`.
struct MessageField {
  enum class Kind { int8, int16, int32, int64, float32, float64, text, boolean, byte, nested };
  struct Dimension {
    std::size_t fixed = 0;  ///< size when not variable
    int length_field = -1;  ///< index of the member that holds the size, or -1
    std::string written;    ///< as in the definition
  };
  std::string name;
  Kind kind = Kind::int8;
  std::string type_name;                ///< as in the definition
  const MessageType* nested = nullptr;  ///< for Kind::nested
  std::vector<Dimension> dimensions;
};

/// Kinds that may hold an array's length.
bool is_integer(MessageField::Kind kind);

/// Bytes of one value on the wire; 0 for text and nested values.
std::size_t value_size(MessageField::Kind kind);

struct MessageType {
  std::string name;     ///< without package
  std::string package;  ///< empty when the definition names none
  std::vector<MessageField> fields;
  std::uint64_t fingerprint = 0;  ///< as LCM computes it from the definition
  std::size_t fixed_size = 0;     ///< bytes on the wire, 0 when it varies

  /// All types of lcmtypes/, by name.
  static const std::vector<const MessageType*>& all();
  /// bot_core's other types (lcmtypes/bot_core/): tools show them, no code is generated for them.
  static const std::vector<const MessageType*>& foreign();
  /// By name: ours before bot_core's (both have a rigid_transform_t).
  static const MessageType* find(const std::string& name);
  /// Also by a fingerprint from before members were renamed or appended.
  static const MessageType* find(std::uint64_t fingerprint);
};

/// Throws DecodeError unless the bytes (fingerprint included) are exactly one message of this type:
/// right fingerprint (or a former one with its members), every length within the message and not negative, no
/// byte left over.
void check_layout(const MessageType& type, const std::uint8_t* data, std::size_t size);

/// A message of a former fingerprint as today's type has it: members that came later are 0. Nothing for a
/// message that is of today. Of bytes that check_layout has found sound.
std::optional<std::vector<std::uint8_t>> completed(const MessageType& type, const std::uint8_t* data,
                                                   std::size_t size);

/// Parses definitions in LCM's language (for tests and tools); throws std::invalid_argument.
std::vector<const MessageType*> parse_definitions(const std::vector<std::string>& texts);

}  // namespace lcmslam
