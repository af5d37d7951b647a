#include <lcmslam/configuration/read_settings.hpp>

#include <algorithm>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {

void SettingsReader::require(bool condition, const char* key, const char* problem) {
  if (condition) return;
  ConfigNode node = nodes_.back();
  std::string name = key;
  for (std::size_t dot = name.find('.'); dot != std::string::npos; dot = name.find('.')) {
    node = node.section(name.substr(0, dot));
    name = name.substr(dot + 1);
  }
  node.fail(name, "'" + std::string(key) + "' " + problem);
}

double SettingsReader::on_number(const Setting& setting, double value) {
  const ConfigNode& node = nodes_.back();
  if (!node.has(setting.key)) return value;
  if (setting.whole) return node.get(setting.key, 0, setting.range);
  return node.get(setting.key, value, setting.range);
}

bool SettingsReader::on_flag(const Setting& setting, bool value) {
  return nodes_.back().get(setting.key, value);
}

std::string SettingsReader::on_text(const Setting& setting, const std::string& value) {
  const ConfigNode& node = nodes_.back();
  if (!setting.choices.empty())
    return node.choice(setting.key, value, {setting.choices.begin(), setting.choices.end()});
  return setting.required && value.empty() ? node.text(setting.key) : node.get(setting.key, value);
}

std::vector<double> SettingsReader::on_numbers(const Setting& setting, const std::vector<double>& values) {
  const std::vector<double> read = nodes_.back().get(setting.key, values);
  for (const double value : read)
    if (!setting.range.holds(value))
      nodes_.back().fail(setting.key, "'" + std::string(setting.key) + "' must be a list, each " +
                                          range_text("a number", setting.range) + ", got " +
                                          number_text(value));
  return read;
}

std::vector<std::string> SettingsReader::on_texts(const Setting& setting,
                                                  const std::vector<std::string>& values) {
  const std::vector<std::string> read = nodes_.back().get(setting.key, values);
  const std::vector<std::string> choices(setting.choices.begin(), setting.choices.end());
  for (const std::string& value : read)
    if (!choices.empty() && std::find(choices.begin(), choices.end(), value) == choices.end())
      nodes_.back().fail(setting.key, "'" + std::string(setting.key) + "' must be a list, each " +
                                          one_of(choices) + ", got '" + value + "'");
  return read;
}

bool SettingsReader::begin_section(const char* key, const char*, bool chosen) {
  if (chosen)
    nodes_.push_back(nodes_.back().section(key));
  else
    nodes_.back().ignore(key);
  return chosen;
}

}  // namespace lcmslam
