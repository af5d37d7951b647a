#include "tools/config/explain.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <stdexcept>

#include <lcmslam/configuration/scalar.hpp>
#include "tools/config/setting_sections.hpp"

namespace lcmslam {
namespace {

bool begins_with(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// Behind the last dot.
std::string last_word(const std::string& key) {
  return key.substr(key.rfind('.') + 1);
}

struct Found {
  const SettingSection* section;
  const SettingEntry* entry;
  std::string key;
};

template <class Condition>
std::vector<Found> find_keys(const Condition& condition) {
  std::vector<Found> found;
  for (const SettingSection& section : setting_sections())
    for (const SettingEntry& entry : section.entries)
      if (const std::string key = section.key(entry); condition(key))
        found.push_back({&section, &entry, key});
  return found;
}

/// ": did you mean 'icp.voxel_size' or 'icp.map.voxel_size'?"
std::string suggestion(const std::string& key, const std::vector<std::string>& others = {}) {
  std::vector<std::string> keys = others, words;
  for (const Found& f : find_keys([](const std::string&) { return true; })) {
    keys.push_back(f.key);
    words.push_back(last_word(f.key));
  }
  std::vector<std::string> near = {nearest_word(key, keys)};
  const std::string word = nearest_word(last_word(key), words, 2);
  for (const std::string& candidate : keys)
    if (!word.empty() && near.size() < 4 && last_word(candidate) == word && candidate != near[0])
      near.push_back(candidate);
  std::string text;
  for (const std::string& candidate : near) text += (text.empty() ? "'" : "' or '") + candidate;
  return "; did you mean " + text + "'?";
}

std::string describe(const Found& f) {
  const SettingEntry& e = *f.entry;
  std::string text = f.key + "\n  " + e.meaning + "\n";
  if (!e.unit.empty()) text += "  unit     " + e.unit + "\n";
  text += "  must be  " + allowed(e) + "\n";
  text += "  default  " + f.section->defaults(e) + "\n";
  std::string yaml = e.required ? "..." : e.value;
  for (std::string rest = f.key; !rest.empty();) {
    const std::size_t dot = rest.rfind('.');
    const std::string name = rest.substr(dot == std::string::npos ? 0 : dot + 1);
    rest = dot == std::string::npos ? "" : rest.substr(0, dot);
    yaml = rest.empty() ? name + ": " + yaml : "{" + name + ": " + yaml + "}";
  }
  return text + "  in YAML  " + yaml + "\n  or       --set " + f.key + "=" + (e.required ? "..." : e.value) +
         "\n";
}

}  // namespace

std::string list_keys(const std::string& name) {
  const auto found =
      find_keys([&](const std::string& key) { return name.empty() || begins_with(key, name + "."); });
  if (found.empty()) {
    std::string sections;
    for (const SettingSection& section : setting_sections())
      sections += (sections.empty() ? "" : ", ") + section.name;
    throw std::invalid_argument("there is no section '" + name + "'; there are " + sections);
  }
  std::size_t key_width = 3, value_width = 7, unit_width = 4;
  for (const Found& f : found) {
    key_width = std::max(key_width, f.key.size());
    value_width = std::max(value_width, f.section->defaults(*f.entry).size());
    unit_width = std::max(unit_width, f.entry->unit.size());
  }
  const auto row = [&](const std::string& key, const std::string& value, const std::string& unit,
                       const std::string& meaning) {
    return fmt::format("{:<{}}  {:<{}}  {:<{}}  {}\n", key, key_width, value,
                       std::min<std::size_t>(value_width, 24), unit, unit_width, meaning);
  };
  std::string text = row("key", "default", "unit", "meaning; what it must be");
  for (const Found& f : found)
    text +=
        row(f.key, f.section->defaults(*f.entry), f.entry->unit, f.entry->meaning + "; " + allowed(*f.entry));
  return text;
}

std::string explain_key(const std::string& key) {
  auto found = find_keys([&](const std::string& k) { return k == key; });
  if (found.empty()) found = find_keys([&](const std::string& k) { return ends_with(k, "." + key); });
  if (found.empty() && !find_keys([&](const std::string& k) { return begins_with(k, key + "."); }).empty())
    return list_keys(key);
  if (found.empty()) throw std::invalid_argument("there is no key '" + key + "'" + suggestion(key));
  std::string text;
  for (const Found& f : found) text += (text.empty() ? "" : "\n") + describe(f);
  return text;
}

}  // namespace lcmslam
