#include "tools/launch/graph.hpp"

#include <algorithm>

#include <lcmslam/runtime/options.hpp>

namespace lcmslam {

std::vector<ProcessSpec> read_graph(const GraphOptions& options) {
  const ConfigNode config = load_config(options.config, options.overrides);
  for (const auto& name : process_names()) config.ignore(name);
  const ConfigNode launch = config.section("launch");
  const auto names = launch.get("processes", process_names());
  const bool restart = launch.get("restart", true);
  config.finish();

  std::filesystem::create_directories(options.folder / "logs");
  std::vector<ProcessSpec> specs;
  for (const auto& name : names) {
    const auto& known = process_names();
    if (std::find(known.begin(), known.end(), name) == known.end())
      launch.fail("processes", "there is no process '" + name + "'");
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
    spec.log = options.folder / "logs" / (name + ".txt");
    spec.restart = restart;
    spec.stop_last = name == "map-server";  // the mappers' last words belong into the map
    specs.push_back(spec);
  }
  return specs;
}

std::filesystem::path program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

}  // namespace lcmslam
