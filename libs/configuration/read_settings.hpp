#pragma once
// From a key in a file to a field of a struct that describes itself (settings/settings.hpp).

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// Changes each field whose key stands in the mapping. Every description counts as asked for, so that
/// ConfigNode::finish() names what is left. Throws ConfigError with file and line for values that are wrong.
class SettingsReader : public SettingsVisitor {
 public:
  explicit SettingsReader(const ConfigNode& config) : nodes_{config} {}
  void require(bool condition, const char* key, const char* problem) override;

 protected:
  double on_number(const Setting& setting, double value) override;
  bool on_flag(const Setting& setting, bool value) override;
  std::string on_text(const Setting& setting, const std::string& value) override;
  std::vector<double> on_numbers(const Setting& setting, const std::vector<double>& values) override;
  std::vector<std::string> on_texts(const Setting& setting, const std::vector<std::string>& values) override;
  bool begin_section(const char* key, const char* meaning, bool chosen) override;
  void end_section() override { nodes_.pop_back(); }

 private:
  std::vector<ConfigNode> nodes_;  // the sections that are open
};

/// `defaults` with what the mapping says.
template <class S>
S read_settings(const ConfigNode& config, S defaults = {}) {
  SettingsReader reader(config);
  defaults.describe(reader);
  return defaults;
}

}  // namespace lcmslam
