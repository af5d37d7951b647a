#pragma once
// The process graph that a configuration names.

#include <map>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/runtime/launch_settings.hpp>
#include "tools/launch/supervisor.hpp"

namespace lcmslam {

struct GraphOptions {
  std::string config;  ///< file
  std::string lcm_url;
  std::string log_level = "info";
  std::vector<std::string> overrides;  ///< section.key=value, handed to every process
  std::filesystem::path folder;        ///< logs/ below it takes the processes' output; empty: none is made
  std::string host{};                  ///< this one's name in the configuration; empty: the machine's
};

struct Graph {
  LaunchSettings launch;
  std::string host;                              ///< this one's name
  std::string lcm_url;                           ///< with launch.ttl
  std::vector<ProcessSpec> processes;            ///< of this host
  std::map<std::string, std::string> elsewhere;  ///< host of each other process
};

/// Reads section `launch` and the processes' names; throws ConfigError, also when nothing of the graph is
/// this host's.
Graph read_graph(const GraphOptions& options);

/// Folder of this program, where the processes' programs are too.
std::filesystem::path program_folder();

}  // namespace lcmslam
