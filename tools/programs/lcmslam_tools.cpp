// `lcmslam-tools`: commands on logs, recordings and the bus; `lcmslam` hands over to it.

#include "tools/commands.hpp"
#include "tools/run_commands.hpp"

int main(int argc, char** argv) {
  using namespace lcmslam;
  return run_commands({{"batch", batch_command},
                       {"calibrate", calibrate_command},
                       {"collect", collect_command},
                       {"config", config_command},
                       {"evaluate", evaluate_command},
                       {"echo", echo_command},
                       {"export", export_command},
                       {"import", import_command},
                       {"lcm-spy", lcm_spy_command},
                       {"log", log_command},
                       {"map", map_command},
                       {"query", query_command},
                       {"render", render_command},
                       {"send", send_command},
                       {"simulate", simulate_command},
                       {"spy", spy_command}},
                      argc, argv);
}
