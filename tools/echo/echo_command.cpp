#include <chrono>
#include <iostream>

#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/above_zero.hpp"
#include "tools/commands.hpp"
#include "tools/echo/echo_log.hpp"
#include "tools/parse_command.hpp"
#include "tools/spy/bus_listener.hpp"

namespace lcmslam {
namespace {

/// False when the reader of a pipe went away.
bool write(const std::string& text) {
  std::cout << text << std::flush;
  return static_cast<bool>(std::cout);
}

/// Exit code: 1 when fewer messages came than were asked for.
int echo_bus(const std::string& lcm_url, const std::string& channels, const EchoOptions& options,
             std::int64_t count, double seconds) {
  install_stop_signals(0);
  EchoPrinter printer(options);
  std::int64_t printed = 0;
  const auto enough = [&] { return count > 0 && printed >= count; };
  BusListener listener(lcm_url, echo_pattern(channels),
                       [&](const std::string& channel, const std::uint8_t* data, std::size_t size) {
                         if (enough()) return;
                         const auto text = printer.print(channel, data, size);
                         if (!text) return;
                         ++printed;
                         if (!write(*text)) request_stop();
                       });
  std::cerr << "listens to " << lcm_url << "\n";
  const auto start = std::chrono::steady_clock::now();
  listener.run([&] {
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    return stop_requested() || enough() || (seconds > 0 && time.count() > seconds);
  });
  return count > 0 && !enough() && !stop_requested() ? 1 : 0;
}

int echo_log_or_say_what_lacks(const EchoLogRequest& request, const EchoOptions& options) {
  const std::int64_t printed = echo_log(request, options, write);
  if (printed >= request.count || !std::cout) return 0;
  std::cerr << request.file << ": has only " << printed << " of them\n";
  return 1;
}

}  // namespace

int echo_command(int argc, char** argv) {
  std::string lcm_url;
  std::vector<std::string> definitions;
  std::optional<double> from;
  EchoLogRequest request;
  EchoOptions options;
  CLI::App app{"Prints the messages of a channel, decoded: those of the bus from now on, or those of a log.",
               "lcmslam echo"};
  app.add_option("channel", request.channels,
                 "channel, or a regular expression of channels such as '.*_POSE'")
      ->required();
  auto* log =
      app.add_option("--log", request.file, "an .lcmlog file instead of the bus")->check(CLI::ExistingFile);
  app.add_option("--from", from, "with --log: seconds from its start, or a utime (us) when above 1e9")
      ->needs(log);
  app.add_option("--count", request.count, "end after so many messages; exit code 1 when fewer came")
      ->check(above_zero());
  app.add_option("--seconds", request.seconds, "end after this time; of a log: so much of it")
      ->check(above_zero());
  auto* json = app.add_flag("--json", options.json, "a line of JSON a message");
  app.add_flag("--full", options.full, "whole arrays and texts");
  app.add_flag("--csv", options.csv,
               "a row a message, below a row of names; arrays whose size varies are left out")
      ->excludes(json);
  app.add_option("--definitions", definitions, "definitions of further types: .lcm files, or folders of them")
      ->check(CLI::ExistingPath);
  app.add_option("--lcm-url", lcm_url,
                 "LCM provider; default LCM_DEFAULT_URL or " + std::string(default_lcm_url))
      ->excludes(log);
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  options.types = KnownTypes(read_definitions(definitions));
  options.pieces = is_part_channel(request.channels);
  if (!request.file.empty()) {
    LogSelection time;  // checks what is no time
    if (from) time.from = request.from = LogTime{*from};
    time.check();
    return echo_log_or_say_what_lacks(request, options);
  }
  if (lcm_url.empty()) lcm_url = lcm_url_from_environment();
  return echo_bus(lcm_url, request.channels, options, request.count, request.seconds);
}

}  // namespace lcmslam
