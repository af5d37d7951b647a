#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <iostream>

#include <lcmslam/runtime/options.hpp>
#include "tools/commands.hpp"
#include "tools/launch/graph.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {

int bridge_command(int argc, char** argv) {
  ProcessOptions options;
  CLI::App app{"Carries chosen channels of the bus to an MQTT broker and from it, until Ctrl-C.",
               "lcmslam bridge"};
  app.add_option("config", options.config, "configuration with a section bridge, e.g. config/operator.yaml")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("--lcm-url", options.lcm_url, "LCM provider");
  app.add_option("--log-level", options.log_level, "trace, debug, info, warn, error or off");
  app.add_option("--set", options.overrides, "override: section.key=value");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;

  std::vector<std::string> words = {program_folder() / "lcmslam-bridge", "--config", options.config,
                                    "--log-level", options.log_level};
  if (!options.lcm_url.empty()) words.insert(words.end(), {"--lcm-url", options.lcm_url});
  for (const std::string& value : options.overrides) words.insert(words.end(), {"--set", value});
  std::vector<char*> arguments;
  for (std::string& text : words) arguments.push_back(text.data());
  arguments.push_back(nullptr);
  execv(arguments.front(), arguments.data());
  std::cerr << "lcmslam bridge: " << words.front() << ": " << std::strerror(errno)
            << "; it is built where libmosquitto-dev is installed\n";
  return 1;
}

}  // namespace lcmslam
