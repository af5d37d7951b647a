#pragma once
// The process graph that a configuration names.

#include <lcmslam/configuration/config.hpp>
#include "tools/launch/supervisor.hpp"

namespace lcmslam {

struct GraphOptions {
  std::string config;  ///< file
  std::string lcm_url;
  std::string log_level = "info";
  std::vector<std::string> overrides;  ///< section.key=value, handed to every process
  std::filesystem::path folder;        ///< logs/ below it takes the processes' output
};

/// Reads section `launch` and the processes' names; throws ConfigError. Keys:
///   launch: {processes: [camera, ...], restart: true}
std::vector<ProcessSpec> read_graph(const GraphOptions& options);

/// Folder of this program, where the processes' programs are too.
std::filesystem::path program_folder();

}  // namespace lcmslam
