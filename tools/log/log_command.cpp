#include "tools/commands.hpp"
#include "tools/log/log_commands.hpp"

namespace lcmslam {

const std::vector<Command>& log_subcommands() {
  static const std::vector<Command> subcommands = {
      {"info", log_info_command, "what is in a log: channels, types, rates, gaps, sessions"},
      {"check", log_check_command, "what is wrong with it; exit code 0 only when nothing is"},
      {"repair", log_repair_command, "a new log with every whole event of a damaged one"},
      {"cut", log_cut_command, "a new log with some of the time or of the channels"},
      {"calibrate", log_calibrate_command, "a new log with a camera's calibration from a file"},
      {"export", log_export_command, "an MCAP file for Foxglove, Lichtblick and other viewers"},
      {"play", log_play_command, "sends a log's messages, at any speed or in step with the mappers"},
      {"view", log_view_command, "shows it in a browser, with a time slider"}};
  return subcommands;
}

int log_command(int argc, char** argv) {
  return run_subcommand("log", log_subcommands(), argc, argv);
}

}  // namespace lcmslam
