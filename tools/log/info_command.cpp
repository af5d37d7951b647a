#include <iostream>

#include "tools/log/log_commands.hpp"
#include "tools/log/log_summary.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {

int log_info_command(int argc, char** argv) {
  std::string file;
  bool json = false;
  CLI::App app{
      "Shows what is in a log. Gaps and lost messages (by their numbers) are those of the recording.",
      "lcmslam log info"};
  app.add_option("log", file, "an .lcmlog file")->required();
  app.add_flag("--json", json, "for programs");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  const LogSummary summary = summarise_log(file);
  std::cout << (json ? summary_json(summary) : format_summary(summary));
  return 0;
}

}  // namespace lcmslam
