#pragma once
// What the bytes of a logged message tell without decoding them as one type.

#include <optional>
#include <string>

#include <lcmslam/log/event_judge.hpp>
#include <lcmslam/messages/origin.hpp>
#include <lcmslam/messages/schema.hpp>

namespace lcmslam {

/// For LogReader: messages of known types must be exactly what their definition says.
Wholeness check_message(std::string_view channel, const std::uint8_t* data, std::size_t size);
/// The same for a message of this type; nullptr: not known.
Wholeness check_message_of(const MessageType* type, const std::uint8_t* data, std::size_t size);

/// LCM's first 8 bytes; nothing when there are fewer.
std::optional<std::uint64_t> fingerprint(const std::uint8_t* data, std::size_t size);

/// Nothing for unknown types.
const MessageType* message_type(const std::uint8_t* data, std::size_t size);

/// Of types that begin with `int64_t utime`.
std::optional<Utime> message_utime(const std::uint8_t* data, std::size_t size);
/// The same for a message of this type; nullptr: not known.
std::optional<Utime> message_utime_of(const MessageType* type, const std::uint8_t* data, std::size_t size);

/// Of types that have seq and sender, and of images_t.
Origin message_origin(const std::uint8_t* data, std::size_t size);

}  // namespace lcmslam
