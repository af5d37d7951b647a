#include <spdlog/spdlog.h>
#include <unistd.h>
#include <algorithm>
#include <iostream>

#include <lcmslam/command_t.hpp>
#include <lcmslam/configuration/config_json.hpp>
#include <lcmslam/configuration/yaml_text.hpp>
#include <lcmslam/runtime/bus_robot.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/private_bus.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/commands.hpp"
#include "tools/demo/run_summary.hpp"
#include "tools/doctor/checks.hpp"
#include "tools/launch/control.hpp"
#include "tools/launch/control_client.hpp"
#include "tools/launch/graph.hpp"
#include "tools/launch/hosts.hpp"
#include "tools/launch/page_watch.hpp"
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
void save_maps_now(LcmPublisher& publisher) {
  command_t command;
  command.utime = 0;
  command.target = "map-server";
  command.name = "save";
  command.n = 0;
  publisher.publish("COMMAND", command);
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

Utime wall_clock() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Where this run's logs and maps go; the user's --set wins.
void choose_folder(GraphOptions& options, const std::string& asked, bool private_bus) {
  options.folder = asked.empty() ? new_run_folder("launch") : std::filesystem::path(asked);
  std::vector<std::string> set = {"map-server.folder=" +
                                  yaml_quoted(std::filesystem::absolute(options.folder).string())};
  if (private_bus) set.emplace_back(without_page);
  options.overrides.insert(options.overrides.begin(), set.begin(), set.end());
}

/// What runs, told and asked from everywhere: the terminal, the bus, the control socket.
class RunningGraph {
 public:
  RunningGraph(const Graph& graph, LcmBus& bus, const std::filesystem::path& page_log)
      : publisher_(bus.lcm(), draw_sender(), largest_whole_message(graph.lcm_url)),
        elsewhere_(graph, publisher_.sender()),
        page_(page_log) {
    for (const auto& spec : graph.processes) supervisor_.start(spec);
  }

  void connect(Inputs& inputs) {
    inputs.subscribe<status_t>("STATUS", 1000, [this](const status_t& s) { on_status(s); });
    if (elsewhere_.any())
      inputs.subscribe<command_t>(clock_channel, 100,
                                  [this](const command_t& m) { elsewhere_.hear(m, wall_clock()); });
  }

  /// Gives what happened, in words.
  std::vector<std::string> work() {
    std::vector<std::string> events = supervisor_.poll();
    const auto now = std::chrono::steady_clock::now();
    if (elsewhere_.any() && now >= next_clock_) {
      publisher_.publish(clock_channel, elsewhere_.tell(wall_clock()));
      next_clock_ = now + Elsewhere::word_period;
      if (std::string warning = elsewhere_.warning(wall_clock()); !warning.empty()) events.push_back(warning);
    }
    for (std::string& news : elsewhere_.news()) events.push_back(std::move(news));
    if (std::string news = page_.news(); !news.empty()) events.push_back(std::move(news));
    return events;
  }

  std::string table() const {
    std::string text = format_status(board_, supervisor_.processes());
    for (const auto& process : supervisor_.processes())
      if (process.waits) text += "  " + supervisor_.wait_of(process) + "\n";
    if (!page_.last().empty()) text += "  " + page_.last() + "\n";
    return text + elsewhere_.format(wall_clock());
  }

  /// To another terminal.
  std::string answer(const std::string& request) {
    const std::string restart = "restart ";
    if (request == "status") return table();
    if (request == "stop") {
      request_stop();
      return "lcmslam launch (" + std::to_string(getpid()) + ") stops\n";
    }
    if (request.rfind(restart, 0) != 0) return "refused: no such request\n";
    const std::string name = request.substr(restart.size());
    const std::string obstacle = supervisor_.restart(name);
    return obstacle.empty() ? name + " starts again\n" : "refused: " + obstacle + "\n";
  }

  Supervisor& supervisor() { return supervisor_; }
  LcmPublisher& publisher() { return publisher_; }

 private:
  void on_status(const status_t& status) {
    take_status(board_, status, supervisor_.processes());
    const bool own = board_.count(status.process) > 0 && board_[status.process].pid == status.pid;
    const bool ready = status.state == status_t::RUNNING || status.state == status_t::FINISHED;
    if ((elsewhere_.take(status) || own) && ready) supervisor_.note_ready(status.process);
  }

  LcmPublisher publisher_;
  Elsewhere elsewhere_;
  PageWatch page_;
  Supervisor supervisor_;
  StatusBoard board_;
  std::chrono::steady_clock::time_point next_clock_{};
};

}  // namespace

int launch_command(int argc, char** argv) {
  GraphOptions options;
  bool private_bus = false;
  RunFacts facts;
  CLI::App app{"Starts the process graph that a configuration names and stops it cleanly on Ctrl-C.",
               "lcmslam launch"};
  auto* config = app.add_option("config", options.config, "configuration, e.g. config/robot.yaml")
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
  app.add_option("--host", options.host,
                 "which of the configuration's hosts this is, default the machine's name");
  bool status = false, stops = false;
  std::string restart, robot;
  app.add_flag("--status", status, "what the launch that runs here does");
  app.add_flag("--stop", stops, "stops the launch that runs here");
  app.add_option("--restart", restart, "starts a process of the launch that runs here again");
  app.add_option("--robot", robot, "with --status, --stop and --restart: whose launch, where several run");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (status || stops || !restart.empty())
    return control_launch(status ? "status" : stops ? "stop" : "restart " + restart, robot);
  if (config->count() == 0) {
    std::cerr << "config is required\nRun with --help for more information.\n";
    return 2;
  }
  if (options.lcm_url.empty()) options.lcm_url = lcm_url_from_environment();
  check_run_folder(folder, force);
  const bool as_root = geteuid() == 0;  // asked before: in a user namespace everybody is root
  if (private_bus && !enter_private_bus()) {
    std::cerr << "lcmslam launch: this machine permits no private network namespace\n";
    return 1;
  }
  const Graph graph = read_graph(options);            // whatever refuses to start leaves no folder
  facts.configuration = config_json(options.config);  // the file may be another when the run ends
  if (const std::string obstacle = obstacle_between_hosts(graph); !obstacle.empty()) {
    std::cerr << "lcmslam launch: " << obstacle << "\n";
    return 2;
  }
  set_robot(graph.launch.robot);
  install_stop_signals(0);
  LcmBus bus(graph.lcm_url);
  const Finding route = check_route(graph.lcm_url, graph.launch.interface);
  if (!bus.usable() || route.level == Finding::Level::failure) {
    std::cerr << "lcmslam launch: LCM cannot use " << graph.lcm_url << "\n" << format_findings({route}, true);
    return 1;
  }
  DoctorOptions doctor;
  doctor.lcm_url = graph.lcm_url;
  doctor.interface = graph.launch.interface;
  const auto is_camera = [](const ProcessSpec& spec) { return spec.name == "camera"; };
  if (std::any_of(graph.processes.begin(), graph.processes.end(), is_camera))  // else its source is elsewhere
    doctor.traffic = graph_traffic(options.config, options.overrides);
  doctor.seconds = 0.3;
  doctor.folder = nearest_folder(folder.empty() ? "out" : folder);
  for (const auto& spec : graph.processes) doctor.processes.push_back(spec.name);
  const auto findings = examine(doctor);
  std::cout << format_findings(findings, false) << std::flush;
  const auto rival = std::find_if(findings.begin(), findings.end(), is_rival_graph);
  if (rival != findings.end()) {
    std::cout << "lcmslam launch: " << rival->text << std::endl;
    return 2;
  }
  choose_folder(options, folder, private_bus);
  RunningGraph running(read_graph(options), bus, map_server_log(options.folder));
  std::optional<ControlSocket> control;
  try {
    control.emplace(control_folder(), graph.launch.robot.empty() ? "launch" : graph.launch.robot);
  } catch (const std::runtime_error& error) {
    std::cout << "lcmslam launch: no --status and --stop from elsewhere: " << error.what() << std::endl;
  }
  std::cout << "lcmslam launch: " << graph.processes.size() << " processes; maps and logs go to "
            << options.folder.string() << std::endl;
  if (private_bus)
    std::cout << "lcmslam launch: its bus is private; another terminal joins it by  nsenter --target "
              << getpid() << (as_root ? "" : " --user --preserve-credentials") << " --net ./lcmslam spy"
              << std::endl;
  if (private_bus && std::count(doctor.processes.begin(), doctor.processes.end(), "map-server") > 0)
    std::cout << "lcmslam launch: " << no_page_on_a_private_bus(options.folder) << std::endl;

  Inputs inputs;
  running.connect(inputs);
  RunRecorder recorder(inputs);
  Receiver receiver(bus, inputs);
  const auto start = std::chrono::steady_clock::now();
  Screen screen;
  Supervisor& supervisor = running.supervisor();
  while (!stop_requested() && !supervisor.refused() && !supervisor.all_stopped()) {
    Arrival arrival;
    if (receiver.take(arrival, std::chrono::milliseconds(100))) arrival.deliver();
    for (const auto& event : running.work()) std::cout << "lcmslam launch: " << event << std::endl;
    if (control) control->poll([&](const std::string& request) { return running.answer(request); });
    screen.show(running.table());
  }
  std::cout << "lcmslam launch: stops" << std::endl;
  save_maps_now(running.publisher());
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
