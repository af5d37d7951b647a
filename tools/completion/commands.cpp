#include "tools/commands.hpp"

#include "tools/log/log_commands.hpp"

namespace lcmslam {

const std::vector<Command>& commands() {
  static const std::vector<Command> all = {
      {"batch", batch_command, "run the whole graph in one process straight from a log"},
      {"completion", completion_command, "print the completion of this command for bash or zsh"},
      {"config", config_command, "say what can be configured; check a file"},
      {"demo", demo_command, "run the whole graph live and show both maps"},
      {"doctor", doctor_command, "look for what makes LCM lose messages on this machine"},
      {"evaluate", evaluate_command, "errors of trajectories against the truth"},
      {"echo", echo_command, "print the messages of a channel, decoded"},
      {"import", import_command, "turn a data set folder into an .lcmlog"},
      {"launch", launch_command, "start the process graph that a configuration names"},
      {"lcm-spy", lcm_spy_command, "the stock graphical spy with our types"},
      {"log", log_command, "recordings: info, check, repair, cut, calibrate, play", log_subcommands()},
      {"render", render_command, "a picture of a map, or one that turns"},
      {"send", send_command, "an order to the running graph: save, smooth, reset, stop, export"},
      {"simulate", simulate_command, "render a simulated run into an .lcmlog"},
      {"spy", spy_command, "live table of the bus"},
      {"study", study_command, "run the demo for several seeds, or one study of its own"}};
  return all;
}

}  // namespace lcmslam
