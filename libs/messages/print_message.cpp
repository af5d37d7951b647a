#include <lcmslam/messages/print_message.hpp>

#include <charconv>
#include <cmath>

namespace lcmslam {
namespace {

using Kind = MessageValue::Kind;

bool is_abridged(const MessageValue& value) {
  return value.length > (value.kind == Kind::array ? value.items.size() : value.text.size());
}

/// Shortest text that reads back as the same number; with `digits` at most so many.
template <class Real>
std::string number(Real value, int digits = 0) {
  char buffer[64];
  const auto end =
      digits == 0 ? std::to_chars(buffer, buffer + sizeof buffer, value)
                  : std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, digits);
  return {buffer, end.ptr};
}

// ---- text

/// Stands below its member's name, not beside it.
bool is_block(const MessageValue& value) {
  if (value.kind == Kind::record) return true;
  return value.kind == Kind::array && !value.items.empty() && is_block(value.items.front());
}

std::string hexadecimal_bytes(const std::string& bytes) {
  static const char digits[] = "0123456789abcdef";
  std::string text;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    if (!text.empty()) text += ' ';
    text += {digits[byte >> 4], digits[byte & 15]};
  }
  return text;
}

std::string inline_text(const MessageValue& value) {
  const std::string length = std::to_string(value.length);
  switch (value.kind) {
    case Kind::integer:
      return std::to_string(value.integer);
    case Kind::boolean:
      return value.integer != 0 ? "true" : "false";
    case Kind::real32:
    case Kind::real64:
      return number(value.real, 6);
    case Kind::text:
      return quoted(value.text) + (is_abridged(value) ? "... " + length + " bytes" : "");
    case Kind::bytes:
      if (value.text.empty()) return length + " bytes";
      return length + " bytes (" + hexadecimal_bytes(value.text) + (is_abridged(value) ? " ...)" : ")");
    case Kind::array: {
      std::string text;
      for (const MessageValue& item : value.items) text += (text.empty() ? "" : ", ") + inline_text(item);
      if (is_abridged(value)) text += (text.empty() ? "... " : ", ... ") + length + " values";
      return "[" + text + "]";
    }
    case Kind::record:
      break;
  }
  return {};
}

void print_items(const MessageValue& value, std::size_t indent, std::string& out);

void print_item(const std::string& label, const MessageValue& value, std::size_t indent, std::string& out) {
  out += std::string(indent, ' ') + label;
  if (!is_block(value)) {
    out += " " + inline_text(value) + "\n";
    return;
  }
  if (value.kind == Kind::array) out += " " + std::to_string(value.length) + " x " + value.type_name;
  out += "\n";
  print_items(value, indent + 2, out);
}

void print_items(const MessageValue& value, std::size_t indent, std::string& out) {
  std::size_t k = 0;
  for (const MessageValue& item : value.items)
    print_item(value.kind == Kind::array ? "[" + std::to_string(k++) + "]" : item.name + ":", item, indent,
               out);
  if (value.kind == Kind::array && is_abridged(value))
    out += std::string(indent, ' ') + "... " + std::to_string(value.length - value.items.size()) + " more\n";
}

// ---- JSON

std::string base64(const std::string& bytes) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

void append_json(const MessageValue& value, std::string& out);

void append_items(const MessageValue& value, std::string& out) {
  const bool record = value.kind == Kind::record;
  out += record ? '{' : '[';
  bool first = true;
  for (const MessageValue& item : value.items) {
    if (!first) out += ',';
    first = false;
    if (record) out += json_string(item.name) + ":";
    append_json(item, out);
  }
  out += record ? '}' : ']';
}

void append_json(const MessageValue& value, std::string& out) {
  const bool abridged = is_abridged(value);
  if (abridged) out += "{\"length\":" + std::to_string(value.length) + ",\"first\":";
  switch (value.kind) {
    case Kind::integer:
      out += std::to_string(value.integer);
      break;
    case Kind::boolean:
      out += value.integer != 0 ? "true" : "false";
      break;
    case Kind::real32:
      out += std::isfinite(value.real) ? number(static_cast<float>(value.real)) : "null";
      break;
    case Kind::real64:
      out += std::isfinite(value.real) ? number(value.real) : "null";
      break;
    case Kind::text:
      out += json_string(value.text);
      break;
    case Kind::bytes:
      out += '"' + base64(value.text) + '"';
      break;
    case Kind::array:
    case Kind::record:
      append_items(value, out);
  }
  if (abridged) out += '}';
}

}  // namespace

std::string print_message(const MessageValue& message, std::size_t indent) {
  std::string text;
  print_items(message, indent, text);
  return text;
}

std::string message_json(const MessageValue& message) {
  std::string text;
  append_json(message, text);
  return text;
}

std::string display_name(const MessageType& type) {
  const bool ours = type.package.empty() || type.package == "lcmslam";
  return ours ? type.name : type.package + "." + type.name;
}

}  // namespace lcmslam
