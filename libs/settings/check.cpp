#include <lcmslam/settings/check.hpp>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace lcmslam {
namespace {

/// Plain where YAML and its flow lists permit.
std::string yaml_text(const std::string& text) {
  const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '/' || c == '.' || c == '-';
  });
  return plain && text[0] != '-' ? text : "'" + text + "'";
}

template <class Values, class Text>
std::string yaml_list(const Values& values, const Text& text) {
  std::string result = "[";
  for (const auto& value : values) result += (result.size() > 1 ? ", " : "") + text(value);
  return result + "]";
}

bool is_choice(const std::string& text, const std::vector<const char*>& choices) {
  return choices.empty() ||
         std::any_of(choices.begin(), choices.end(), [&](const char* c) { return text == c; });
}

std::string must_be_number(const Setting& setting) {
  return "must be " + range_text(setting.whole ? "a whole number" : "a number", setting.range);
}

std::string one_of(const std::vector<const char*>& choices) {
  return lcmslam::one_of(std::vector<std::string>(choices.begin(), choices.end()));
}

}  // namespace

std::string range_text(const std::string& kind, const Range& range) {
  const bool low = std::isfinite(range.low), high = std::isfinite(range.high);
  if (low && high) return kind + " from " + number_text(range.low) + " to " + number_text(range.high);
  if (low) return kind + " of at least " + number_text(range.low);
  if (high) return kind + " of at most " + number_text(range.high);
  return kind;
}

std::string number_text(double number) {
  char text[64];
  const double size = std::abs(number);
  const bool fixed = number == 0 || (size >= 1e-4 && size < 1e10);
  const auto format = fixed ? std::chars_format::fixed : std::chars_format::general;
  return {text, std::to_chars(text, text + sizeof text, number, format).ptr};
}

std::string one_of(const std::vector<std::string>& choices) {
  std::string text = "one of";
  for (const std::string& name : choices) text += (&name == &choices.front() ? " '" : ", '") + name + "'";
  return text;
}

std::string allowed(const SettingEntry& entry) {
  if (entry.kind == "true or false") return entry.kind;
  if (entry.kind == "list of texts")
    return entry.choices.empty() ? "a list of texts" : "a list, each " + one_of(entry.choices);
  if (!entry.choices.empty()) return one_of(entry.choices);
  return range_text("a " + entry.kind, entry.range);
}

// --- lists ---

void SettingsLister::add(const Setting& setting, const char* kind, std::string value) {
  const std::string prefix = prefixes_.empty() ? "" : prefixes_.back();
  entries.push_back({prefix + setting.key,
                     std::move(value),
                     setting.unit,
                     kind,
                     setting.range,
                     {setting.choices.begin(), setting.choices.end()},
                     setting.meaning,
                     setting.required});
}

double SettingsLister::on_number(const Setting& setting, double value) {
  add(setting, setting.whole ? "whole number" : "number",
      setting.whole ? std::to_string(static_cast<long long>(value)) : number_text(value));
  return value;
}

bool SettingsLister::on_flag(const Setting& setting, bool value) {
  add(setting, "true or false", value ? "true" : "false");
  return value;
}

std::string SettingsLister::on_text(const Setting& setting, const std::string& value) {
  add(setting, "text", yaml_text(value));
  return value;
}

std::vector<double> SettingsLister::on_numbers(const Setting& setting, const std::vector<double>& values) {
  add(setting, "list of numbers", yaml_list(values, number_text));
  return values;
}

std::vector<std::string> SettingsLister::on_texts(const Setting& setting,
                                                  const std::vector<std::string>& values) {
  add(setting, "list of texts", yaml_list(values, yaml_text));
  return values;
}

bool SettingsLister::begin_section(const char* key, const char*, bool) {
  prefixes_.push_back((prefixes_.empty() ? "" : prefixes_.back()) + key + ".");
  return true;
}

void SettingsLister::end_section() {
  prefixes_.pop_back();
}

// --- checks ---

void SettingsCheck::remember(const char* key, std::string problem) {
  if (failed()) return;
  for (const char* section : sections_) path_ += std::string(section) + ".";
  path_ += key;
  problem_ = std::move(problem);
}

void SettingsCheck::fail(const char* what, const std::vector<SettingEntry>& entries) const {
  std::string text = std::string(what) + (*what == '\0' ? "" : ": ") + path_;
  for (const SettingEntry& entry : entries)
    if (entry.path == path_)
      text += " is " + entry.value + (entry.unit.empty() ? "" : " " + entry.unit) + ",";
  throw std::invalid_argument(text + " " + problem_);
}

void SettingsCheck::require(bool condition, const char* key, const char* problem) {
  if (!condition) remember(key, problem);
}

double SettingsCheck::on_number(const Setting& setting, double value) {
  if (!(std::isfinite(value) && setting.range.holds(value))) remember(setting.key, must_be_number(setting));
  return value;
}

std::string SettingsCheck::on_text(const Setting& setting, const std::string& value) {
  if (!is_choice(value, setting.choices)) remember(setting.key, "must be " + one_of(setting.choices));
  if (setting.required && value.empty()) remember(setting.key, "must be given");
  return value;
}

std::vector<double> SettingsCheck::on_numbers(const Setting& setting, const std::vector<double>& values) {
  for (const double value : values)
    if (!(std::isfinite(value) && setting.range.holds(value)))
      remember(setting.key, "must be a list, each " + range_text("a number", setting.range));
  return values;
}

std::vector<std::string> SettingsCheck::on_texts(const Setting& setting,
                                                 const std::vector<std::string>& values) {
  for (const std::string& value : values)
    if (!is_choice(value, setting.choices))
      remember(setting.key, "must be a list, each " + one_of(setting.choices));
  return values;
}

bool SettingsCheck::begin_section(const char* key, const char*, bool chosen) {
  if (chosen) sections_.push_back(key);
  return chosen;
}

}  // namespace lcmslam
