// `lcmslam`: what starts the graph. All other commands are in programs of their own, for which a first demo
// need not wait.

#include "tools/commands.hpp"
#include "tools/run_commands.hpp"

namespace {

int tools(int, char** argv) {
  lcmslam::hand_over("lcmslam-tools", argv - 1);
  return 1;
}

int study(int, char** argv) {
  lcmslam::hand_over("lcmslam-study", argv - 1);
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace lcmslam;
  return run_commands({{"batch", tools},
                       {"calibrate", tools},
                       {"collect", tools},
                       {"completion", study},
                       {"config", tools},
                       {"demo", demo_command},
                       {"doctor", doctor_command},
                       {"evaluate", tools},
                       {"echo", tools},
                       {"export", tools},
                       {"import", tools},
                       {"launch", launch_command},
                       {"lcm-spy", tools},
                       {"log", tools},
                       {"map", tools},
                       {"query", tools},
                       {"render", tools},
                       {"send", tools},
                       {"simulate", tools},
                       {"spy", tools},
                       {"study", study}},
                      argc, argv);
}
