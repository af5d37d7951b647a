#pragma once
// Messages for people (text) and for scripts (JSON).

#include <string>

#include <lcmslam/messages/message_value.hpp>

namespace lcmslam {

/// One member a line, what is nested indented by two more blanks; numbers with six digits. What was
/// abridged says its length:
///   utime: 1262300000
///   rms: [0.012, 0.011, ... 9 values]
///   data: 81234 bytes (ff d8 ff e0 ...)
std::string print_message(const MessageValue& message, std::size_t indent = 0);

/// One line of JSON, numbers exact. NaN and infinities, which JSON lacks, are null; bytes are base64; what
/// was abridged is {"length": 9, "first": [...]}.
std::string message_json(const MessageValue& message);

/// Text from the bus in quotes, so that it can do nothing to a terminal: control characters and what is no
/// UTF-8 are escaped.
std::string quoted(const std::string& text);
/// The same without quotes, for names.
std::string printable(const std::string& text);
/// A JSON string; what is no UTF-8 becomes U+FFFD.
std::string json_string(const std::string& text);

/// "images_t"; other people's types with their package: "bot_core.utime_t".
std::string display_name(const MessageType& type);

}  // namespace lcmslam
