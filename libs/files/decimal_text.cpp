#include <lcmslam/files/decimal_text.hpp>

#include <charconv>

namespace lcmslam {
namespace {

void append_number(std::string& text, double number, std::chars_format format, int precision) {
  char digits[400];  // the greatest double has 309 before its point
  text.append(digits, std::to_chars(digits, digits + sizeof digits, number, format, precision).ptr);
}

}  // namespace

void append_fixed(std::string& text, double number, int decimals) {
  append_number(text, number, std::chars_format::fixed, decimals);
}

void append_general(std::string& text, double number, int digits) {
  append_number(text, number, std::chars_format::general, digits);
}

}  // namespace lcmslam
