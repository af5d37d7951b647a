#pragma once
// The members of a JSON object, each read once and checked; whatever is wrong is a std::invalid_argument that
// says where and what would be right.

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>

#include <lcmslam/settings/range.hpp>

namespace lcmslam {

class JsonFields {
 public:
  explicit JsonFields(const nlohmann::json& object) : object_(object) {
    if (!object.is_object()) throw std::invalid_argument("a question is an object: {\"ask\": ...}");
  }

  const nlohmann::json* find(const std::string& key) {
    read_.insert(key);
    const auto found = object_.find(key);
    return found != object_.end() ? &*found : nullptr;
  }
  const nlohmann::json& need(const std::string& key) {
    const nlohmann::json* value = find(key);
    if (value == nullptr) throw std::invalid_argument("'" + key + "' is missing");
    return *value;
  }

  std::string text(const std::string& key) {
    const nlohmann::json& value = need(key);
    if (!value.is_string()) wrong(key, value, "must be a text");
    return value.get<std::string>();
  }
  double number(const std::string& key, double otherwise, const Range& range) {
    const nlohmann::json* value = find(key);
    if (value == nullptr) return otherwise;
    if (!value->is_number()) wrong(key, *value, "must be a number");
    const auto number = value->get<double>();
    if (!range.holds(number)) wrong(key, *value, "must be " + range_text("a number", range));
    return number;
  }
  bool flag(const std::string& key) {
    const nlohmann::json* value = find(key);
    if (value != nullptr && !value->is_boolean()) wrong(key, *value, "must be true or false");
    return value != nullptr && value->get<bool>();
  }
  template <std::size_t n>
  std::array<double, n> numbers(const std::string& key) {
    return numbers<n>(key, need(key));
  }
  /// A list of rows of n numbers.
  template <std::size_t n>
  std::vector<std::array<double, n>> rows(const std::string& key, std::size_t most) {
    const nlohmann::json& list = need(key);
    if (!list.is_array() || list.empty() || list.size() > most)
      throw std::invalid_argument("'" + key + "' must be a list of 1 to " + std::to_string(most) +
                                  " rows of " + std::to_string(n) + " numbers");
    std::vector<std::array<double, n>> rows;
    rows.reserve(list.size());
    for (const nlohmann::json& row : list) rows.push_back(numbers<n>(key, row));
    return rows;
  }

  /// Throws where a member was never asked for.
  void done() const {
    for (const auto& [key, value] : object_.items())
      if (read_.count(key) == 0) {
        std::string known;
        for (const std::string& name : read_) known += (known.empty() ? "" : ", ") + name;
        throw std::invalid_argument("'" + key.substr(0, 40) + "' is not asked for; there are " + known);
      }
  }

 private:
  [[noreturn]] static void wrong(const std::string& key, const nlohmann::json& value,
                                 const std::string& right) {
    using nlohmann::json;
    throw std::invalid_argument("'" + key + "' is " +
                                value.dump(-1, ' ', true, json::error_handler_t::replace).substr(0, 60) +
                                ", " + right);
  }
  template <std::size_t n>
  static std::array<double, n> numbers(const std::string& key, const nlohmann::json& row) {
    std::array<double, n> values;
    const bool right = row.is_array() && row.size() == n;
    for (std::size_t i = 0; i < n; ++i) {
      if (!right || !row[i].is_number()) wrong(key, row, "must be " + std::to_string(n) + " numbers");
      values[i] = row[i].get<double>();
      if (!(std::abs(values[i]) <= 1e6)) wrong(key, row, "must lie within 1e6");
    }
    return values;
  }

  const nlohmann::json& object_;
  std::set<std::string> read_;
};

}  // namespace lcmslam
