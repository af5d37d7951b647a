#include <chrono>
#include <fstream>
#include <iostream>
#include <sstream>

#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/commands.hpp"
#include "tools/echo/echo_printer.hpp"
#include "tools/parse_command.hpp"
#include "tools/spy/bus_listener.hpp"

namespace lcmslam {
namespace {

std::vector<const MessageType*> read_definitions(const std::vector<std::string>& files) {
  std::vector<std::string> texts;
  std::string names;
  for (const std::string& file : files) {
    names += " " + file;
    std::ifstream in(file);
    std::ostringstream text;
    text << in.rdbuf();
    if (!in) throw std::runtime_error(file + ": cannot be read");
    texts.push_back(text.str());
  }
  try {
    return parse_definitions(texts);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error("--definitions" + names + ": " + error.what());
  }
}

}  // namespace

int echo_command(int argc, char** argv) {
  std::string channels, lcm_url;
  std::vector<std::string> definitions;
  std::int64_t count = 0;
  double seconds = 0;
  EchoOptions options;
  CLI::App app{"Prints the messages of a channel, decoded.", "lcmslam echo"};
  app.add_option("channel", channels, "channel, or a regular expression of channels such as '.*_POSE'")
      ->required();
  app.add_option("--count", count, "end after so many messages")->check(CLI::PositiveNumber);
  app.add_option("--seconds", seconds, "end after this time; exit code 1 when --count did not come")
      ->check(CLI::PositiveNumber);
  app.add_flag("--json", options.json, "a line of JSON a message");
  app.add_flag("--full", options.full, "whole arrays and texts");
  app.add_option("--definitions", definitions, "definitions of further types (.lcm)")
      ->check(CLI::ExistingFile);
  app.add_option("--lcm-url", lcm_url,
                 "LCM provider; default LCM_DEFAULT_URL or " + std::string(default_lcm_url));
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (lcm_url.empty()) lcm_url = lcm_url_from_environment();
  options.types = read_definitions(definitions);
  options.pieces = is_part_channel(channels);

  install_stop_signals(0);
  EchoPrinter printer(options);
  std::int64_t printed = 0;
  const auto enough = [&] { return count > 0 && printed >= count; };
  BusListener listener(lcm_url, echo_pattern(channels),
                       [&](const std::string& channel, const std::uint8_t* data, std::size_t size) {
                         if (enough()) return;
                         const auto text = printer.print(channel, data, size);
                         if (!text) return;
                         std::cout << *text << std::flush;
                         ++printed;
                         if (!std::cout) request_stop();  // the reader of a pipe went away
                       });
  std::cerr << "listens to " << lcm_url << "\n";
  const auto start = std::chrono::steady_clock::now();
  listener.run([&] {
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    return stop_requested() || enough() || (seconds > 0 && time.count() > seconds);
  });
  return count > 0 && !enough() && !stop_requested() ? 1 : 0;
}

}  // namespace lcmslam
