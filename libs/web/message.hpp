#pragma once
// What travels on /live (docs/LIVE_PAGE.md): the header's length, the header, the payload.

#include <memory>
#include <string>
#include <string_view>

namespace lcmslam {

/// Shared by all clients that it goes to.
using WebMessage = std::shared_ptr<const std::string>;

/// `header` is a JSON object without channel and key, which it gets here, and spaces behind it to a multiple
/// of 4 bytes.
WebMessage encode_message(const std::string& channel, const std::string& key, std::string_view header,
                          std::string_view payload);

/// Bytes from `at` on of a message that is too long to go at once, at most `size`; browsers put them
/// together. `stream`: of which one message is under way at a time.
WebMessage encode_part(const std::string& stream, const std::string& message, std::size_t at,
                       std::size_t size);

}  // namespace lcmslam
