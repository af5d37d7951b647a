#include <lcmslam/configuration/scalar.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace lcmslam {
namespace {

/// All of the text as a number of type T, independent of the locale.
template <class T>
std::optional<T> parse_all(const YamlValue& value) {
  if (value.kind != YamlValue::Kind::scalar || value.quoted || value.text.empty()) return {};
  const char* begin = value.text.data();
  const char* end = begin + value.text.size();
  if (*begin == '+' && end - begin > 1 && begin[1] != '-') ++begin;
  T number{};
  const auto [stop, error] = std::from_chars(begin, end, number);
  if (error != std::errc() || stop != end) return {};
  return number;
}

}  // namespace

std::optional<double> read_number(const YamlValue& value, const Range& range) {
  const std::optional<double> number = parse_all<double>(value);
  if (!number || !std::isfinite(*number) || !range.holds(*number)) return {};
  return number;
}

std::optional<int> read_whole_number(const YamlValue& value, const Range& range) {
  const std::optional<int> number = parse_all<int>(value);
  if (!number || !range.holds(*number)) return {};
  return number;
}

std::optional<bool> read_bool(const YamlValue& value) {
  if (value.kind != YamlValue::Kind::scalar || value.quoted) return {};
  if (value.text == "true" || value.text == "yes") return true;
  if (value.text == "false" || value.text == "no") return false;
  return {};
}

std::optional<std::string> read_text(const YamlValue& value) {
  if (value.kind != YamlValue::Kind::scalar) return {};
  return value.text;
}

}  // namespace lcmslam
