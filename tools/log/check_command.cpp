#include <fmt/format.h>
#include <iostream>

#include "tools/log/log_check.hpp"
#include "tools/log/log_commands.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

/// True when the log is clean.
bool check(const std::string& file, std::size_t shown) {
  const LogCheck result = check_log(file);
  for (std::size_t i = 0; i < result.findings.size() && i < shown; ++i)
    std::cout << file << ": " << format_finding(result.findings[i]) << "\n";
  if (result.findings.size() > shown)
    std::cout << file << ": " << result.findings.size() - shown << " more findings; --all shows them\n";
  std::string summary = fmt::format("{} events", result.events);
  if (result.sessions > 1) summary += fmt::format(" in {} sessions", result.sessions);
  if (result.unknown_types > 0)
    summary += fmt::format(", {} of unknown types (only their framing was checked)", result.unknown_types);
  if (result.jittered > 0)
    summary += fmt::format(", {} logged a little early (by {:.1f} ms at most)", result.jittered,
                           1e-3 * static_cast<double>(result.largest_jitter));
  const std::size_t n = result.findings.size();
  std::cout << fmt::format("{}: {}: {}\n", file, summary,
                           n == 0 ? "clean" : fmt::format("{} finding{}", n, n == 1 ? "" : "s"));
  return n == 0;
}

}  // namespace

int log_check_command(int argc, char** argv) {
  std::vector<std::string> files;
  bool all = false;
  CLI::App app{
      "Checks framing, order, times and every message of a known type, images included. Exit code 0: all "
      "clean.",
      "lcmslam log check"};
  app.add_option("logs", files, ".lcmlog files")->required();
  app.add_flag("--all", all, "show all findings (default: the first 30 of a log)");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  bool clean = true;
  for (const auto& file : files) {
    try {
      clean &= check(file, all ? SIZE_MAX : 30);
    } catch (const std::exception& error) {
      std::cout << error.what() << "\n";
      clean = false;
    }
  }
  return clean ? 0 : 1;
}

}  // namespace lcmslam
