#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>

#include <lcmslam/messages/print_message.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/log/lcm_play_bus.hpp"
#include "tools/log/log_commands.hpp"
#include "tools/log/message_reader.hpp"
#include "tools/log/selection_options.hpp"
#include "tools/process_channels.hpp"

namespace lcmslam {
namespace {

using std::chrono::seconds;

/// The mappers and what they answer a frame with.
const std::map<std::string, std::string> mappers{{"fastslam", "FASTSLAM_POSE"}, {"icp", "ICP_POSE"}};

struct PlayOptions {
  std::string file, lcm_url;
  std::optional<double> speed;
  bool lockstep = false;
  std::vector<std::string> answers, processes;
  double wait = 60;
  SelectionOptions selection;
};

std::set<std::string> candidates(const PlayOptions& options) {
  std::set<std::string> channels(options.answers.begin(), options.answers.end());
  if (channels.empty())
    for (const auto& [process, channel] : mappers) channels.insert(channel);
  return options.lockstep ? channels : std::set<std::string>{};
}

void wait_for_processes(LcmPlayBus& bus, const PlayOptions& options) {
  const std::set<std::string> wanted(options.processes.begin(), options.processes.end());
  if (wanted.empty()) return;
  std::cout << fmt::format("waits for {}", fmt::join(wanted, ", ")) << std::endl;
  const auto limit =
      std::chrono::duration_cast<PlayBus::Time::duration>(std::chrono::duration<double>(options.wait));
  if (bus.wait_for(wanted, bus.now() + limit) || bus.stopped()) return;
  std::set<std::string> missing;
  for (const auto& process : wanted)
    if (bus.running().count(process) == 0) missing.insert(process);
  throw std::runtime_error(
      fmt::format("{} s went by without STATUS (running) of {}", options.wait, fmt::join(missing, ", ")));
}

/// The answer channels of the mappers that run.
std::set<std::string> find_answers(LcmPlayBus& bus, const PlayOptions& options) {
  if (!options.lockstep || !options.answers.empty()) return candidates(options);
  std::set<std::string> found;
  const auto until = bus.now() + seconds(10);
  while (found.empty() && bus.now() < until && !bus.stopped()) {
    bus.wait_until(until);
    for (const auto& [process, channel] : mappers)
      if (bus.running().count(process) > 0) found.insert(channel);
  }
  if (found.empty() && !bus.stopped())
    throw std::runtime_error(
        "no mapper reports that it runs: start a graph (lcmslam launch CONFIG), or name the channels that "
        "answer a frame (--answer)");
  // STATUS comes once a second: the others' must have come by then.
  bus.wait_for({"fastslam", "icp"}, bus.now() + std::chrono::milliseconds(1500));
  for (const auto& [process, channel] : mappers)
    if (bus.running().count(process) > 0) found.insert(channel);
  return found;
}

/// Who computes what this log may hold as well; where nobody is heard a whole graph is awaited.
std::set<std::string> find_graph(LcmPlayBus& bus, const PlayOptions& options, const PlaySettings& settings) {
  const std::set<std::string> whole(process_names().begin(), process_names().end());
  const bool chosen = settings.all_channels || !settings.selection.channels.empty();
  if (chosen || computed_channels(scan_log(options.file).channels, whole).empty()) return whole;
  const auto until = bus.now() + std::chrono::milliseconds(1500);  // STATUS comes once a second
  while (bus.now() < until && !bus.stopped()) bus.wait_until(until);
  std::set<std::string> graph = bus.present();
  graph.insert(options.processes.begin(), options.processes.end());
  return graph.empty() ? whole : graph;
}

std::string names(const std::set<std::string>& channels) {
  return printable(fmt::format("{}", fmt::join(channels, ", ")));
}

void print_start(const PlayOptions& options, const PlaySettings& settings) {
  const auto contents = scan_log(options.file);
  const auto played = channels_to_play(contents.channels, settings);
  std::set<std::string> others;
  for (const auto& channel : contents.channels)
    if (played.count(channel) == 0) others.insert(channel);
  std::cout << fmt::format("{}: plays {}", options.file, names(played));
  if (!others.empty()) std::cout << fmt::format("; not {} (--all or --channels)", names(others));
  if (!settings.answer_channels.empty())
    std::cout << fmt::format("; in step with {}", fmt::join(settings.answer_channels, ", "));
  std::cout << std::endl;
}

void print_end(const PlayCounts& counts, bool lockstep) {
  std::cout << fmt::format("{} messages, {} frames", counts.messages, counts.frames);
  if (lockstep) {
    if (counts.uncovered > 0)
      std::cout << fmt::format(" ({} that odometry's last reading does not cover: mappers may not answer)",
                               counts.uncovered);
    std::cout << fmt::format(", {} answered by all, {} given up", counts.answered,
                             counts.frames - counts.answered);
    for (const auto& [channel, count] : counts.answers)
      std::cout << fmt::format("; {} answered {}{}", channel, count.answered,
                               count.silent ? " (no longer waited for)" : "");
  }
  std::cout << fmt::format("; {:.2f} s of the log in {:.2f} s: {:.2f} times real time\n", counts.log_seconds,
                           counts.seconds, counts.log_seconds / std::max(counts.seconds, 1e-9));
}

}  // namespace

int log_play_command(int argc, char** argv) {
  PlayOptions options;
  PlaySettings settings;
  CLI::App app{
      "Sends a log's messages on the bus, in the log's order and at its intervals, but for what the graph "
      "that is heard there (where none is, a whole one) computes itself from the others.",
      "lcmslam log play"};
  app.add_option("log", options.file, "an .lcmlog file")->required();
  app.add_option("--speed", options.speed,
                 "1: as recorded (default), 0: as fast as possible (default with --lockstep)");
  options.selection.add_to(app);
  app.add_flag("--loop", settings.loop, "again and again, until Ctrl-C");
  app.add_flag("--all", settings.all_channels, "all channels, also what the graph computes itself");
  app.add_option("--lcm-url", options.lcm_url, "LCM provider");
  app.add_option("--wait-for", options.processes, "first wait until these processes run: A,B,...")
      ->delimiter(',');
  app.add_option("--wait", options.wait, "s, at most, for --wait-for (default 60)")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--lockstep", options.lockstep,
               "a frame goes out when the mappers have answered the one before: nothing is dropped");
  app.add_option("--answer", options.answers,
                 "the channels that answer a frame (default: the poses of the mappers that run)")
      ->delimiter(',');
  app.add_option("--patience", settings.patience, "s to wait for the answers to a frame (default 5)");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (!options.answers.empty() && !options.lockstep)
    throw std::invalid_argument("--answer is for --lockstep, which is not given");
  settings.speed = options.speed.value_or(options.lockstep ? 0 : 1);
  settings.selection = options.selection.selection();
  if (options.lcm_url.empty()) options.lcm_url = lcm_url_from_environment();
  scan_log(options.file);  // a log that cannot be played is reported before anything is waited for

  install_stop_signals(0);
  LcmPlayBus bus(options.lcm_url, candidates(options));
  wait_for_processes(bus, options);
  settings.answer_channels = find_answers(bus, options);
  settings.processes = find_graph(bus, options, settings);
  if (bus.stopped()) return 0;
  print_start(options, settings);
  const PlayCounts counts = play_log(options.file, settings, bus);
  print_end(counts, options.lockstep);
  if (bus.split() > 0) std::cout << bus.split() << " messages went out in pieces\n";
  const bool unheard = options.lockstep && counts.frames > 0 && counts.answered == 0 && !bus.stopped();
  if (unheard) std::cerr << "lcmslam log: no frame was answered by all: does the graph run as it should?\n";
  return unheard ? 1 : 0;
}

}  // namespace lcmslam
