#include "tools/launch/graph.hpp"

#include <unistd.h>
#include <algorithm>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/runtime/bus_robot.hpp>
#include <lcmslam/runtime/launch_settings.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tools/launch/hosts.hpp"

namespace lcmslam {

namespace {

/// What of a process's settings the supervisor needs.
void take_over(ProcessSpec& spec, const LaunchedProcess& process) {
  constexpr double megabyte = 1e6;
  spec.after = process.after;
  spec.environment = process.environment;
  for (const double cpu : process.cpus) spec.limits.cpus.push_back(static_cast<int>(cpu));
  spec.limits.nice = process.nice;
  spec.limits.memory = static_cast<std::uint64_t>(process.memory * megabyte);
}

std::string host_name() {
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
}

/// Fails unless one of the graph's hosts is this one.
void check_host(const LaunchSettings& launch, const std::string& host, const ConfigNode& section) {
  const std::vector<std::string> hosts = launch.hosts();
  if (hosts.empty() || std::find(hosts.begin(), hosts.end(), host) != hosts.end()) return;
  std::string names;
  for (const std::string& name : hosts) names += (names.empty() ? "" : ", ") + name;
  section.fail("processes", "this host is '" + host +
                                "' (launch --host NAME says otherwise), but the graph runs on " + names);
}

}  // namespace

Graph read_graph(const GraphOptions& options) {
  const ConfigNode config = load_config(options.config, options.overrides);
  for (const auto& name : section_names()) config.ignore(name);
  const ConfigNode section = config.section("launch");
  Graph graph;
  graph.launch = read_settings<LaunchSettings>(section);
  config.finish();
  const LaunchSettings& launch = graph.launch;
  graph.host = options.host.empty() ? host_name() : options.host;
  check_host(launch, graph.host, section);
  graph.lcm_url = with_ttl(options.lcm_url, launch.ttl);
  if (!launch.robot.empty()) check_robot_name(launch.robot);

  if (!options.folder.empty()) std::filesystem::create_directories(options.folder / "logs");
  for (const auto& name : launch.processes) {
    if (const std::string host = launch.host_of(name); !host.empty() && host != graph.host) {
      graph.elsewhere[name] = host;
      continue;
    }
    ProcessSpec spec;
    spec.name = name;
    spec.arguments = {program_folder() / ("lcmslam-" + name),
                      "--config",
                      options.config,
                      "--lcm-url",
                      graph.lcm_url,
                      "--log-level",
                      options.log_level};
    for (const auto& value : options.overrides) {
      spec.arguments.push_back("--set");
      spec.arguments.push_back(value);
    }
    // A mapper that comes back does not know where it is in the map of the one that ended.
    if (name == "fastslam" || name == "icp") spec.on_restart = "--set=" + name + ".map_frame=map-restart-";
    spec.log = options.folder / "logs" / (name + ".txt");
    spec.log_bytes = static_cast<std::uintmax_t>(launch.log_size * 1e6);
    spec.log_files = launch.log_files;
    spec.restart = launch.restart;
    spec.restart_limit = launch.restart_limit;
    spec.stop_last = name == "map-server" || name == "bridge";  // the mappers' last words belong to them
    take_over(spec, launch.of.at(name));
    graph.processes.push_back(spec);
  }
  return graph;
}

std::filesystem::path program_folder() {
  static const std::filesystem::path program =
      std::filesystem::read_symlink("/proc/self/exe");  // see share_folder()
  return program.parent_path();
}

}  // namespace lcmslam
