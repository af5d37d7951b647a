// Texts from the bus are anybody's bytes.

#include <cstdio>

#include <lcmslam/configuration/utf8.hpp>
#include <lcmslam/messages/print_message.hpp>

namespace lcmslam {
namespace {

unsigned byte_at(const std::string& text, std::size_t i) {
  return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
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
    const auto size = utf8_character_size(text, i);
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
