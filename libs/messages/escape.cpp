// Texts from the bus are anybody's bytes.

#include <cstdio>
#include <optional>

#include <lcmslam/messages/print_message.hpp>

namespace lcmslam {
namespace {

unsigned byte_at(const std::string& text, std::size_t i) {
  return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
}

/// Bytes of the well-formed UTF-8 character at i (RFC 3629), none when there is no such.
std::optional<std::size_t> character_size(const std::string& text, std::size_t i) {
  const unsigned lead = byte_at(text, i);
  if (lead < 0x80) return 1;
  const std::size_t size = lead < 0xc2 ? 0 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : lead < 0xf5 ? 4 : 0;
  if (size == 0) return std::nullopt;
  for (std::size_t k = 1; k < size; ++k)
    if ((byte_at(text, i + k) & 0xc0) != 0x80) return std::nullopt;
  const unsigned second = byte_at(text, i + 1);
  const bool overlong = (lead == 0xe0 && second < 0xa0) || (lead == 0xf0 && second < 0x90);
  const bool surrogate = lead == 0xed && second > 0x9f;
  const bool too_high = lead == 0xf4 && second > 0x8f;
  if (overlong || surrogate || too_high) return std::nullopt;
  return size;
}

/// C0, DEL and C1 (two bytes in UTF-8): terminals act on them.
bool is_control(const std::string& text, std::size_t i) {
  const unsigned c = byte_at(text, i);
  return c < 0x20 || c == 0x7f || (c == 0xc2 && byte_at(text, i + 1) < 0xa0);
}

template <class Escape>
std::string escaped(const std::string& text, Escape escape) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    const auto size = character_size(text, i);
    const std::size_t step = size.value_or(1);
    const bool special = !size || is_control(text, i) || text[i] == '"' || text[i] == '\\';
    result += special ? escape(i, step, size.has_value()) : text.substr(i, step);
    i += step;
  }
  return result;
}

std::string hexadecimal(const char* format, unsigned value) {
  char buffer[16];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

std::string short_escape(char c) {
  switch (c) {
    case '\n':
      return "\\n";
    case '\t':
      return "\\t";
    case '\r':
      return "\\r";
    case '"':
      return "\\\"";
    case '\\':
      return "\\\\";
    default:
      return {};
  }
}

}  // namespace

std::string printable(const std::string& text) {
  return escaped(text, [&](std::size_t i, std::size_t size, bool) {
    std::string result = short_escape(text[i]);
    if (result.empty())
      for (std::size_t k = 0; k < size; ++k) result += hexadecimal("\\x%02x", byte_at(text, i + k));
    return result;
  });
}

std::string quoted(const std::string& text) {
  return '"' + printable(text) + '"';
}

std::string json_string(const std::string& text) {
  return '"' +
         escaped(text,
                 [&](std::size_t i, std::size_t size, bool well_formed) -> std::string {
                   if (!well_formed) return "\\ufffd";
                   if (size > 1) return hexadecimal("\\u%04x", byte_at(text, i + 1));  // C1: its second byte
                   const std::string result = short_escape(text[i]);
                   return result.empty() ? hexadecimal("\\u%04x", byte_at(text, i)) : result;
                 }) +
         '"';
}

}  // namespace lcmslam
