#include <cstring>
#include <exception>
#include <iostream>

#include "commands.hpp"
#include "runtime/options.hpp"

int main(int argc, char** argv) {
  using namespace lcmslam;
  struct Command {
    const char* name;
    int (*run)(int, char**);
  };
  const Command commands[] = {
      {"batch", batch_command},       {"demo", demo_command},       {"doctor", doctor_command},
      {"evaluate", evaluate_command}, {"echo", echo_command},       {"import", import_command},
      {"launch", launch_command},     {"lcm-spy", lcm_spy_command}, {"log", log_command},
      {"simulate", simulate_command}, {"spy", spy_command},         {"study", study_command}};
  const char* name = argc > 1 ? argv[1] : "";
  for (const Command& command : commands) {
    if (std::strcmp(command.name, name) != 0) continue;
    try {
      return command.run(argc - 1, argv + 1);
    } catch (const std::exception& error) {
      std::cerr << "lcmslam " << name << ": " << error.what() << "\n";
      return 1;
    }
  }
  if (std::strcmp(name, "--version") == 0) {
    std::cout << "lcmslam " << lcmslam_version << "\n";
    return 0;
  }
  if (std::strcmp(name, "--help") == 0) {
    std::cout << "usage: lcmslam COMMAND [options]; lcmslam COMMAND --help for its options. Commands:";
    for (const Command& command : commands) std::cout << " " << command.name;
    std::cout << "\n";
    return 0;
  }
  std::cerr << "lcmslam: unknown command '" << name << "'; ./lcmslam help lists them\n";
  return 2;
}
