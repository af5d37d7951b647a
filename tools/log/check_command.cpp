#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>

#include <lcmslam/messages/print_message.hpp>
#include "tools/log/log_check.hpp"
#include "tools/log/log_commands.hpp"
#include "tools/log/log_plausibility.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

/// What a log without findings may be called: of types that are not known nobody can say that they are sound.
std::string verdict(const LogCheck& result) {
  const std::size_t n = result.findings.size();
  if (n > 0) return fmt::format("{} finding{}", n, n == 1 ? "" : "s");
  if (result.unknown_types == 0) return "clean";
  return fmt::format("nothing wrong in the {} that could be judged", result.events - result.unknown_types);
}

/// True when nothing is wrong with the log as far as it can be judged.
bool check(const std::string& file, const KnownTypes& types, std::size_t shown) {
  const LogCheck result = check_log(file, types);
  for (std::size_t i = 0; i < result.findings.size() && i < shown; ++i)
    std::cout << file << ": " << format_finding(result.findings[i]) << "\n";
  if (result.findings.size() > shown)
    std::cout << file << ": " << result.findings.size() - shown << " more findings; --all shows them\n";
  std::string summary = fmt::format("{} events", result.events);
  if (result.sessions > 1) summary += fmt::format(" in {} sessions", result.sessions);
  if (result.unknown_types > 0)
    summary += fmt::format(
        ", {} of unknown types could not be judged (only their framing was; {}: --definitions makes them "
        "known)",
        result.unknown_types, printable(fmt::format("{}", fmt::join(result.unknown_channels, ", "))));
  if (result.jittered > 0)
    summary += fmt::format(", {} logged a little early (by {:.1f} ms at most)", result.jittered,
                           1e-3 * static_cast<double>(result.largest_jitter));
  std::cout << fmt::format("{}: {}: {}\n", file, summary, verdict(result));
  std::cout << format_plausibility(plausibility_of_log(file));
  return result.findings.empty();
}

}  // namespace

int log_check_command(int argc, char** argv) {
  std::vector<std::string> files, definitions;
  bool all = false;
  CLI::App app{
      "Checks framing, order, times and every message of a known type, images included. Exit code 0: nothing "
      "is wrong with what could be judged. What looks wrong beside that (depths, mount, edges of a dozen "
      "frames) is "
      "said.",
      "lcmslam log check"};
  app.add_option("logs", files, ".lcmlog files")->required();
  app.add_option("--definitions", definitions, "definitions of further types: .lcm files, or folders of them")
      ->check(CLI::ExistingPath);
  app.add_flag("--all", all, "show all findings (default: the first 30 of a log)");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  const KnownTypes types(read_definitions(definitions));
  bool clean = true;
  for (const auto& file : files) {
    try {
      clean &= check(file, types, all ? SIZE_MAX : 30);
    } catch (const std::exception& error) {
      std::cout << error.what() << "\n";
      clean = false;
    }
  }
  return clean ? 0 : 1;
}

}  // namespace lcmslam
