#include <lcmslam/runtime/options.hpp>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <iostream>

#include <lcmslam/runtime/bus_robot.hpp>
#include <lcmslam/runtime/version.hpp>

namespace lcmslam {

bool parse_options(int argc, char** argv, const std::string& process, const std::string& description,
                   ProcessOptions& options, int& exit_code) {
  CLI::App app{description, "lcmslam-" + process};
  app.set_version_flag("--version", std::string("lcmslam ") + lcmslam_version);
  app.add_option("--config", options.config, "configuration file (YAML)")->check(CLI::ExistingFile);
  app.add_option("--lcm-url", options.lcm_url,
                 "LCM provider, default LCM_DEFAULT_URL or " + std::string(default_lcm_url));
  app.add_option("--log-level", options.log_level, "trace, debug, info, warn, error or off")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "off"}));
  app.add_option("--set", options.overrides, "override of the configuration: section.key=value");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    exit_code = app.exit(error) == 0 ? 0 : 2;
    return false;
  }
  if (options.lcm_url.empty()) options.lcm_url = lcm_url_from_environment();
  setenv("LCM_DEFAULT_URL", options.lcm_url.c_str(), 1);  // what this process starts is on the same bus
  return true;
}

std::string lcm_url_from_environment() {
  const char* url = std::getenv("LCM_DEFAULT_URL");
  return url != nullptr && *url != '\0' ? url : default_lcm_url;
}

const std::vector<std::string>& process_names() {
  static const std::vector<std::string> names = {"camera",   "surf", "odometry",
                                                 "fastslam", "icp",  "map-server"};
  return names;
}

const std::vector<std::string>& section_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all = process_names();
    all.emplace_back("bridge");
    return all;
  }();
  return names;
}

ConfigNode load_config(const std::string& file, const std::vector<std::string>& overrides) {
  ConfigNode config = file.empty() ? ConfigNode() : ConfigNode::load(file);
  if (!file.empty() && config.keys().empty())
    throw ConfigError(file + ": is empty: must hold keys and values, such as 'include: modern.yaml'");
  for (const auto& text : overrides) {
    const std::size_t equal = text.find('=');
    if (equal == std::string::npos || equal == 0)
      throw ConfigError("--set " + text + ": must be section.key=value");
    const std::string key = text.substr(0, equal);
    const auto& sections = section_names();
    if (key.find('.') == std::string::npos && key != "launch" &&
        std::find(sections.begin(), sections.end(), key) == sections.end())
      throw ConfigError("--set " + text + ": must be section.key=value; lcmslam config --explain " + key +
                        " finds the section");
    config.set(key, text.substr(equal + 1));
  }
  return config;
}

ProcessConfig process_config(const ProcessOptions& options, const std::string& process) {
  ConfigNode file = load_config(options.config, options.overrides);
  for (const auto& name : section_names())
    if (name != process) file.ignore(name);
  set_robot(file.section("launch").get("robot", ""));  // launch hands it on; for a process started by hand
  file.ignore("launch");
  return {file, file.section(process)};
}

}  // namespace lcmslam
