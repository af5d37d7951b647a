#include <lcmslam/configuration/yaml_text.hpp>

namespace lcmslam {

std::string yaml_quoted(const std::string& text) {
  static const char* const digits = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      quoted += std::string("\\") + c;
    else if (byte < 0x20 || byte == 0x7f)
      quoted += std::string("\\x") + digits[byte >> 4] + digits[byte & 15];
    else
      quoted += c;
  }
  return quoted + "\"";
}

}  // namespace lcmslam
