#pragma once
// Command line shared by all processes.

#include <string>
#include <vector>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// Asks for a receive buffer that big messages need and keeps traffic on this machine (docs/LCM.md).
constexpr const char* default_lcm_url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";

struct ProcessOptions {
  std::string config;
  std::string lcm_url;  ///< from --lcm-url, else LCM_DEFAULT_URL, else default_lcm_url
  std::string log_level = "info";
  std::vector<std::string> overrides;  ///< --set key=value
};

/// Parses; for --help, --version and errors prints and returns the exit code in `exit_code`.
bool parse_options(int argc, char** argv, const std::string& process, const std::string& description,
                   ProcessOptions& options, int& exit_code);

/// The URL when none is given.
std::string lcm_url_from_environment();

/// Names of the processes, which are also the configuration's sections.
const std::vector<std::string>& process_names();

/// All of these, and those that a graph has only when its configuration names them: the bridge.
const std::vector<std::string>& section_names();

/// The whole configuration file with overrides applied ("section.key=value"); throws ConfigError.
ConfigNode load_config(const std::string& file, const std::vector<std::string>& overrides);

/// One process's section; keys of other processes are theirs to check. finish() must be called on
/// the first when the section has been read.
struct ProcessConfig {
  ConfigNode file;
  ConfigNode section;
};
ProcessConfig process_config(const ProcessOptions& options, const std::string& process);

}  // namespace lcmslam
