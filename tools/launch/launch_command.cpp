#include <spdlog/spdlog.h>
#include <unistd.h>
#include <algorithm>
#include <iostream>

#include <lcmslam/command_t.hpp>
#include <lcmslam/configuration/yaml_text.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/private_bus.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/commands.hpp"
#include "tools/demo/run_summary.hpp"
#include "tools/doctor/checks.hpp"
#include "tools/launch/graph.hpp"
#include "tools/launch/status_table.hpp"
#include "tools/parse_command.hpp"
#include "tools/run_folder.hpp"

namespace lcmslam {
namespace {

/// In a terminal the table is drawn over itself; in a file it is appended every ten seconds.
class Screen {
 public:
  void show(const std::string& table) {
    const auto now = std::chrono::steady_clock::now();
    const auto period = terminal_ ? std::chrono::seconds(1) : std::chrono::seconds(10);
    if (now - last_ < period) return;
    last_ = now;
    if (terminal_) std::cout << "\x1b[H\x1b[2J";
    std::cout << table << std::flush;
  }

 private:
  bool terminal_ = isatty(STDOUT_FILENO) != 0;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// What the mappers still have to do at their end may take long: what is mapped is saved meanwhile.
void save_maps_now(lcm::LCM& lcm, const std::string& lcm_url) {
  command_t command;
  command.utime = 0;
  command.target = "map-server";
  command.name = "save";
  command.n = 0;
  LcmPublisher(lcm, draw_sender(), largest_whole_message(lcm_url)).publish("COMMAND", command);
}

/// Gives the exit code; what went wrong first stands on the last line.
int stop(Supervisor& supervisor, const std::filesystem::path& folder,
         const std::function<void()>& write_files) {
  const auto tell = [](const std::string& text) { std::cout << "lcmslam launch: " << text << std::endl; };
  std::vector<std::string> problems = supervisor.stop(std::chrono::seconds(20), tell);
  try {
    write_files();
  } catch (const std::exception& error) {
    problems.emplace_back(error.what());
  }
  for (const auto& problem : problems) tell(problem);
  if (problems.empty())
    tell("all is saved in " + folder.string());
  else
    tell("not all went well, first: " + problems.front());
  return supervisor.refused() ? 2 : problems.empty() ? 0 : 1;
}

}  // namespace

int launch_command(int argc, char** argv) {
  GraphOptions options;
  bool private_bus = false;
  RunFacts facts;
  CLI::App app{"Starts the process graph that a configuration names and stops it cleanly on Ctrl-C.",
               "lcmslam launch"};
  app.add_option("config", options.config, "configuration, e.g. config/robot.yaml")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("--lcm-url", options.lcm_url, "LCM provider");
  app.add_option("--log-level", options.log_level, "of the processes");
  app.add_option("--set", options.overrides, "override: section.key=value");
  std::string folder;
  app.add_option("--out", folder, "folder for maps and logs (default out/launch-TIME)");
  bool force = false;
  app.add_flag("--force", force, "overwrite another run's results in that folder");
  app.add_flag("--kitti", facts.kitti, "trajectories in KITTI's format too");
  app.add_flag("--private-bus", private_bus,
               "own network namespace: nobody else hears or disturbs the graph");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (options.lcm_url.empty()) options.lcm_url = lcm_url_from_environment();
  check_run_folder(folder, force);
  options.folder = folder.empty() ? new_run_folder("launch") : std::filesystem::path(folder);
  const bool as_root = geteuid() == 0;  // asked before: in a user namespace everybody is root
  if (private_bus && !enter_private_bus()) {
    std::cerr << "lcmslam launch: this machine permits no private network namespace\n";
    return 1;
  }

  // Maps go to this run's folder: a new run must not overwrite the last one's. The user's --set wins.
  options.overrides.insert(
      options.overrides.begin(),
      "map-server.folder=" + yaml_quoted(std::filesystem::absolute(options.folder).string()));
  const auto specs = read_graph(options);
  install_stop_signals(0);
  LcmBus bus(options.lcm_url);
  if (!bus.usable()) {
    std::cerr << "lcmslam launch: LCM cannot use " << options.lcm_url << "\n"
              << format_findings({check_route(options.lcm_url)}, true);
    return 1;
  }
  DoctorOptions doctor;
  doctor.lcm_url = options.lcm_url;
  doctor.traffic = graph_traffic(options.config, options.overrides);
  doctor.seconds = 0.3;
  doctor.folder = options.folder;
  for (const auto& spec : specs) doctor.processes.push_back(spec.name);
  const auto findings = examine(doctor);
  std::cout << format_findings(findings, false) << std::flush;
  const auto rival = std::find_if(findings.begin(), findings.end(), is_rival_graph);
  if (rival != findings.end()) {
    std::cout << "lcmslam launch: " << rival->text << std::endl;
    return 2;
  }
  Supervisor supervisor;
  for (const auto& spec : specs) supervisor.start(spec);
  std::cout << "lcmslam launch: " << specs.size() << " processes; maps and logs go to "
            << options.folder.string() << std::endl;
  if (private_bus)
    std::cout << "lcmslam launch: its bus is private; another terminal joins it by  nsenter --target "
              << getpid() << (as_root ? "" : " --user --preserve-credentials") << " --net ./lcmslam spy"
              << std::endl;

  StatusBoard board;
  Inputs inputs;
  inputs.subscribe<status_t>("STATUS", 1000,
                             [&](const status_t& s) { take_status(board, s, supervisor.processes()); });
  RunRecorder recorder(inputs);
  Receiver receiver(bus, inputs);
  const auto start = std::chrono::steady_clock::now();
  Screen screen;
  while (!stop_requested() && !supervisor.refused() && !supervisor.all_stopped()) {
    Arrival arrival;
    if (receiver.take(arrival, std::chrono::milliseconds(100))) arrival.deliver();
    for (const auto& event : supervisor.poll()) std::cout << "lcmslam launch: " << event << std::endl;
    screen.show(format_status(board, supervisor.processes()));
  }
  std::cout << "lcmslam launch: stops" << std::endl;
  save_maps_now(bus.lcm(), options.lcm_url);
  facts.title = "graph of " + options.config;
  facts.config = options.config;
  facts.overrides = options.overrides;
  facts.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return stop(supervisor, options.folder, [&] {
    for (Arrival last; receiver.take(last, std::chrono::milliseconds(0));) last.deliver();
    write_run_files(options.folder, recorder, facts);
  });
}

}  // namespace lcmslam
