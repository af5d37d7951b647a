#include <cstring>
#include <iostream>

#include <lcmslam/configuration/nearest_word.hpp>
#include "tools/commands.hpp"
#include "tools/log/log_commands.hpp"

namespace lcmslam {
namespace {

void print_help(std::ostream& stream) {
  stream << "usage: lcmslam log SUBCOMMAND [options]; lcmslam log SUBCOMMAND --help for its options\n";
  for (const Command& subcommand : log_subcommands())
    stream << "  " << subcommand.name << std::string(11 - std::strlen(subcommand.name), ' ')
           << subcommand.help << "\n";
}

}  // namespace

const std::vector<Command>& log_subcommands() {
  static const std::vector<Command> subcommands = {
      {"info", log_info_command, "what is in a log: channels, types, rates, gaps, sessions"},
      {"check", log_check_command, "what is wrong with it; exit code 0 only when nothing is"},
      {"repair", log_repair_command, "a new log with every whole event of a damaged one"},
      {"cut", log_cut_command, "a new log with some of the time or of the channels"},
      {"calibrate", log_calibrate_command, "a new log with a camera's calibration from a file"},
      {"play", log_play_command, "sends a log's messages, at any speed or in step with the mappers"}};
  return subcommands;
}

int log_command(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "";
  for (const Command& subcommand : log_subcommands())
    if (name == subcommand.name) return subcommand.run(argc - 1, argv + 1);
  if (name == "--help" || name == "-h") {
    print_help(std::cout);
    return 0;
  }
  std::vector<std::string> names;
  for (const Command& subcommand : log_subcommands()) names.emplace_back(subcommand.name);
  if (!name.empty())
    std::cerr << "lcmslam log: unknown subcommand '" << name << "'" << did_you_mean(name, names) << "\n";
  print_help(std::cerr);
  return 2;
}

}  // namespace lcmslam
