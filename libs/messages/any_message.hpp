#pragma once
// What can be said of a message whose type is known only by its fingerprint: for whoever hands messages on.

#include <cstdint>
#include <vector>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/messages/origin.hpp>
#include <lcmslam/messages/schema.hpp>

namespace lcmslam {

struct AnyMessage {
  const MessageType* type = nullptr;
  Utime utime = 0;
  Origin origin;  ///< of CAMERA, whose number stands in metadata, and of other people's types: unknown
};

/// Throws DecodeError unless the bytes are exactly one message of lcmtypes/.
AnyMessage identify(const std::uint8_t* data, std::size_t size);

/// Gives a message that is numbered (seq and sender behind its utime) another number; others stay as they
/// are. Who hands on every tenth message would else be taken for one that loses nine.
void renumber(std::vector<std::uint8_t>& message, const AnyMessage& is, std::int64_t seq);

}  // namespace lcmslam
