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

namespace {

/// Optimal string alignment distance.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replace});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

}  // namespace

std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates,
                         std::size_t farthest) {
  const std::string key = word.substr(0, 200);  // quadratic: a key of a megabyte must not stall us
  std::string best;
  std::size_t best_distance = 0;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(key, candidate);
    if (distance > farthest || (!best.empty() && distance >= best_distance)) continue;
    best = candidate;
    best_distance = distance;
  }
  return best;
}

}  // namespace lcmslam
