#include "tools/launch/graph.hpp"

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/runtime/options.hpp>

namespace lcmslam {

std::vector<ProcessSpec> read_graph(const GraphOptions& options) {
  const ConfigNode config = load_config(options.config, options.overrides);
  for (const auto& name : section_names()) config.ignore(name);
  const auto launch = read_settings<LaunchSettings>(config.section("launch"));
  config.finish();

  std::filesystem::create_directories(options.folder / "logs");
  std::vector<ProcessSpec> specs;
  for (const auto& name : launch.processes) {
    ProcessSpec spec;
    spec.name = name;
    spec.arguments = {program_folder() / ("lcmslam-" + name),
                      "--config",
                      options.config,
                      "--lcm-url",
                      options.lcm_url,
                      "--log-level",
                      options.log_level};
    for (const auto& value : options.overrides) {
      spec.arguments.push_back("--set");
      spec.arguments.push_back(value);
    }
    // A mapper that comes back does not know where it is in the map of the one that ended.
    if (name == "fastslam" || name == "icp") spec.on_restart = "--set=" + name + ".map_frame=map-restart-";
    spec.log = options.folder / "logs" / (name + ".txt");
    spec.restart = launch.restart;
    spec.stop_last = name == "map-server";  // the mappers' last words belong into the map
    specs.push_back(spec);
  }
  return specs;
}

std::filesystem::path program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

}  // namespace lcmslam
