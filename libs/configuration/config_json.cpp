#include <lcmslam/configuration/config_json.hpp>

#include <cstdio>

#include <lcmslam/configuration/scalar.hpp>
#include <lcmslam/configuration/yaml_tree.hpp>

namespace lcmslam {
namespace {

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    char escape[8];
    std::snprintf(escape, sizeof escape, "\\u%04x", byte);
    if (c == '"' || c == '\\')
      result += std::string("\\") + c;
    else
      result += byte < 0x20 ? std::string(escape) : std::string(1, c);
  }
  return result + "\"";
}

/// A number in 17 digits reads back as itself.
std::string scalar_json(const YamlValue& value) {
  if (const auto flag = read_bool(value)) return *flag ? "true" : "false";
  if (const auto number = read_number(value, {})) {
    char digits[40];
    std::snprintf(digits, sizeof digits, "%.17g", *number);
    return digits;
  }
  return quoted(value.text);
}

std::string json(const YamlValue& value) {
  std::string text;
  switch (value.kind) {
    case YamlValue::Kind::null:
      return "null";
    case YamlValue::Kind::scalar:
      return scalar_json(value);
    case YamlValue::Kind::sequence:
      for (const YamlPointer& item : value.items) text += (text.empty() ? "" : ", ") + json(*item);
      return "[" + text + "]";
    case YamlValue::Kind::mapping:
      for (const YamlEntry& entry : value.entries)
        text += (text.empty() ? "" : ", ") + quoted(entry.key) + ": " + json(*entry.value);
      return "{" + text + "}";
  }
  return "null";
}

}  // namespace

std::string config_json(const std::filesystem::path& file) {
  return json(*load_yaml(file));
}

}  // namespace lcmslam
