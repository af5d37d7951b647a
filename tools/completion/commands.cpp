#include "tools/commands.hpp"

#include "tools/calibrate/calibrate_commands.hpp"
#include "tools/command_help.hpp"
#include "tools/log/log_commands.hpp"
#include "tools/map/map_commands.hpp"

namespace lcmslam {
namespace {

Command described(const char* name, int (*run)(int, char**), std::vector<Command> below = {}) {
  return {name, run, command_help(name), std::move(below)};
}

}  // namespace

const std::vector<Command>& commands() {
  static const std::vector<Command> all = {described("batch", batch_command),
                                           described("calibrate", calibrate_command, calibrate_subcommands()),
                                           described("collect", collect_command),
                                           described("completion", completion_command),
                                           described("config", config_command),
                                           described("demo", demo_command),
                                           described("doctor", doctor_command),
                                           described("evaluate", evaluate_command),
                                           described("echo", echo_command),
                                           described("export", export_command),
                                           described("import", import_command),
                                           described("launch", launch_command),
                                           described("lcm-spy", lcm_spy_command),
                                           described("log", log_command, log_subcommands()),
                                           described("map", map_command, map_subcommands()),
                                           described("query", query_command),
                                           described("render", render_command),
                                           described("send", send_command),
                                           described("simulate", simulate_command),
                                           described("spy", spy_command),
                                           described("study", study_command)};
  return all;
}

}  // namespace lcmslam
