#include <fmt/format.h>
#include <unistd.h>
#include <iostream>

#include <lcmslam/configuration/config_json.hpp>
#include <lcmslam/configuration/share.hpp>
#include <lcmslam/configuration/yaml_text.hpp>
#include <lcmslam/map_request_t.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/private_bus.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "procs/camera/camera_settings.hpp"
#include "tools/above_zero.hpp"
#include "tools/commands.hpp"
#include "tools/demo/demo_progress.hpp"
#include "tools/demo/run_recorder.hpp"
#include "tools/demo/run_summary.hpp"
#include "tools/doctor/checks.hpp"
#include "tools/launch/graph.hpp"
#include "tools/launch/page_watch.hpp"
#include "tools/parse_command.hpp"
#include "tools/run_folder.hpp"
#include "tools/time_left.hpp"

namespace lcmslam {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds progress_period{1};
constexpr std::chrono::seconds quiet_time{2};  // without a new pose: the mappers have worked off everything
constexpr std::chrono::seconds longest_answer{20};
constexpr std::chrono::seconds longest_saving{50};  // a process gives itself a minute to stop
constexpr std::chrono::seconds longest_start{60};

struct DemoOptions {
  std::string config, data, calibration, out, lcm_url, log_level = "info";
  CameraSettings camera;  // by the configuration
  std::vector<std::string> overrides;
  double seconds = 0;
  int seed = -1;
  bool headless = false, kitti = false, force = false;
  bool private_bus = false;
};

std::optional<int> parse(int argc, char** argv, DemoOptions& o) {
  CLI::App app{"Runs the whole graph live, on the simulated kitchen or a recording, and shows both maps.",
               "lcmslam demo"};
  app.add_option("--data", o.data,
                 "data set folder instead of the simulation: TUM RGB-D, 7-Scenes, numbered images")
      ->check(CLI::ExistingDirectory);
  app.add_option("--calibration", o.calibration, "camera calibration (YAML) for --data")
      ->check(CLI::ExistingFile);
  app.add_option("--config", o.config,
                 "graph and settings (default config/demo.yaml, with --data config/dataset.yaml)")
      ->check(CLI::ExistingFile);
  app.add_option("--seconds", o.seconds, "only the first so many seconds")->check(above_zero());
  app.add_option("--seed", o.seed, "of the simulated sensors and the particles")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--headless", o.headless, "plain progress lines, and no pictures are opened at the end");
  app.add_flag("--kitti", o.kitti, "trajectories in KITTI's format too");
  app.add_option("--out", o.out, "folder for the results (default out/NAME-TIME)");
  app.add_flag("--force", o.force, "overwrite another run's results in that folder");
  app.add_option("--set", o.overrides, "override of the configuration: section.key=value");
  app.add_option("--lcm-url", o.lcm_url, "LCM provider");
  app.add_option("--log-level", o.log_level, "of the processes");
  return parse_command(app, argc, argv);
}

std::string absolute(const std::string& path) {
  return yaml_quoted(std::filesystem::absolute(path).lexically_normal().string());
}

/// Options become overrides of the configuration. Throws ConfigError, also for a graph without a source.
void complete(DemoOptions& o) {
  if (o.config.empty()) o.config = share_path(o.data.empty() ? "config/demo.yaml" : "config/dataset.yaml");
  o.config = std::filesystem::absolute(o.config).lexically_normal();
  if (o.lcm_url.empty()) o.lcm_url = lcm_url_from_environment();

  std::vector<std::string> set;
  if (!o.data.empty())
    set.insert(set.end(), {"camera.source=dataset", "camera.dataset.folder=" + absolute(o.data)});
  if (!o.calibration.empty()) set.push_back("camera.dataset.calibration=" + absolute(o.calibration));
  if (o.seed >= 0)
    for (const char* key : {"fastslam.seed=", "odometry.seed=", "camera.simulation.seed="})
      set.push_back(key + std::to_string(o.seed));
  o.overrides.insert(o.overrides.begin(), set.begin(), set.end());  // the user's own --set has the last word

  const ConfigNode config = load_config(o.config, o.overrides);
  if (!config.has("camera"))
    throw ConfigError(o.config + ": has no camera, so the run would never end; use launch");
  o.camera = read_camera_settings(config.section("camera"));
  if (o.camera.source == "calibration")
    throw ConfigError(o.config +
                      ": its camera only calibrates another driver's images, so the run would never end; "
                      "use launch");
  if (!o.calibration.empty() && o.camera.source != "dataset")
    throw ConfigError("--calibration: is for a recording (--data FOLDER); this graph's camera.source is '" +
                      o.camera.source + "'");
  if (o.seconds > 0) {
    if (o.camera.source == "log") throw ConfigError("--seconds: a log is played whole; cut it first");
    o.overrides.push_back("camera." + o.camera.source + ".seconds=" + std::to_string(o.seconds));
  }
  read_graph({o.config, o.lcm_url, o.log_level, o.overrides, {}});
}

/// Where none was named one is made: who is refused leaves none.
void make_folder(DemoOptions& o) {
  const std::string name = o.data.empty() ? "demo" : std::filesystem::path(o.data).filename().string();
  if (o.out.empty()) o.out = new_run_folder(name.empty() ? "data" : name);
  o.out = std::filesystem::absolute(o.out).lexically_normal();
  o.overrides.insert(o.overrides.begin(), "map-server.folder=" + absolute(o.out));
  std::filesystem::create_directories(o.out);
}

class Demo {
 public:
  Demo(const DemoOptions& options, LcmBus& bus)
      : options_(options),
        publisher_(bus.lcm(), draw_sender(), largest_whole_message(options.lcm_url)),
        recorder_(inputs_),
        receiver_(bus, inputs_),
        page_(map_server_log(options.out)),
        terminal_(isatty(STDOUT_FILENO) != 0 && !options.headless) {}

  int run() {
    facts_.title = title();
    facts_.config = options_.config;
    facts_.configuration = config_json(options_.config);
    facts_.overrides = options_.overrides;
    facts_.kitti = options_.kitti;
    GraphOptions graph{options_.config, options_.lcm_url, options_.log_level, options_.overrides,
                       options_.out};
    for (ProcessSpec spec : read_graph(graph).processes) {
      spec.after.clear();  // all at once: the simulation waits for the others itself
      supervisor_.start(spec);
    }
    std::cout << "lcmslam demo: " << facts_.title << "\n  results go to " << options_.out << std::endl;
    if (options_.private_bus) say("  " + no_page_on_a_private_bus(options_.out));

    const Clock::time_point start = Clock::now();
    const int failure = map_until_end(start);
    facts_.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    if (failure != 0) return failure;

    std::vector<std::string> problems;
    const auto tried = [&](const auto& action) {
      try {
        action();
      } catch (const std::exception& error) {
        problems.emplace_back(error.what());
      }
    };
    tried([&] { ask_for_the_maps_size(); });
    say("  saving the maps", true);  // once: the map server does as it stops, when the mappers have
    for (const auto& problem : supervisor_.stop(longest_saving)) {
      facts_.events.push_back(problem);
      problems.push_back(problem);
    }
    std::cout << format_summary(recorder_, facts_);
    tried([&] { write_run_files(options_.out, recorder_, facts_); });
    if (!problems.empty()) {  // the first cause on the last line
      say("lcmslam demo: " + problems.front());
      return 1;
    }
    std::cout << "\n  maps, pictures, trajectories and summary.json: " << options_.out << "\n";
    show_pictures();
    return 0;
  }

 private:
  void listen(Clock::duration wait) {
    Arrival arrival;
    if (receiver_.take(arrival, wait)) arrival.deliver();
    for (const auto& event : supervisor_.poll()) {
      facts_.events.push_back(event);
      say("lcmslam demo: " + event);
    }
  }

  /// 0 at the end of the source, else the exit code.
  int map_until_end(Clock::time_point start) {
    Clock::time_point next_progress = start;
    Clock::time_point last_change = start;
    std::int64_t last_progress = -1;
    while (true) {
      if (stop_requested()) {
        say("lcmslam demo: stopped by a signal; no summary is written");
        return 130;
      }
      listen(std::chrono::milliseconds(50));
      if (supervisor_.refused()) return 2;
      std::string reason;
      if (recorder_.source_failed(reason)) {
        say("lcmslam demo: the source failed: " + reason);
        return 1;
      }
      const auto now = Clock::now();
      if (recorder_.progress() != last_progress) {
        last_progress = recorder_.progress();
        last_change = now;
      }
      if (recorder_.source_finished() && now - last_change > quiet_time) return 0;
      if (recorder_.board().empty() && now - start > longest_start) {
        say("lcmslam demo: no process reports; see " + options_.out + "/logs");
        return 1;
      }
      if (now >= next_progress) {
        if (const std::string news = page_.news(); !news.empty()) say("  " + news);
        show_progress(std::chrono::duration<double>(now - start).count());
        next_progress = now + progress_period;
      }
    }
  }

  void show_progress(double elapsed) {
    const auto camera = recorder_.board().find("camera");
    if (camera == recorder_.board().end() || camera->second.state == status_t::STARTING) {
      say(format_start(elapsed, recorder_.board(), supervisor_.processes().size()), true);
      return;
    }
    const double frames = status_value(camera->second, "frames");
    const double total = status_value(camera->second, "frames_total");
    if (frames > 0 && mapping_since_ < 0) mapping_since_ = elapsed;
    std::string line = fmt::format("  {:>3.0f} s  {}  frame {:.0f}/{:.0f}", elapsed,
                                   recorder_.source_finished() ? "finishing" : "mapping", frames, total);
    for (const auto& [name, path] :
         {std::pair("odometry", &recorder_.odometry()), std::pair("fastslam", &recorder_.fastslam()),
          std::pair("icp", &recorder_.icp())}) {
      const auto report = recorder_.evaluate_path(*path);
      if (report) line += fmt::format("  {} {:.3f} m", name, report->absolute.translation.rmse);
    }
    const auto left = time_left(elapsed - mapping_since_, total > 0 ? frames / total : 0);
    say(line + (left ? fmt::format("  {:.0f} s left", *left) : ""), true);
  }

  /// For the summary. Throws std::runtime_error without an answer.
  void ask_for_the_maps_size() {
    map_request_t request;
    request.utime = recorder_.icp().trajectory.empty() ? 0 : recorder_.icp().trajectory.back().utime;
    request.request_id = publisher_.sender();
    request.kind = map_request_t::INFO;
    request.n_numbers = 0;
    publisher_.publish("MAP_REQUEST", request);
    const auto deadline = Clock::now() + longest_answer;
    while (!recorder_.reply() || recorder_.reply()->request_id != request.request_id) {
      listen(std::chrono::milliseconds(50));
      if (Clock::now() > deadline || stop_requested())
        throw std::runtime_error("map-server did not answer; see " + options_.out + "/logs/map-server.txt");
    }
  }

  /// In a terminal, progress overwrites itself.
  void say(const std::string& line, bool passing = false) {
    if (terminal_)
      std::cout << "\r\x1b[K" << line << (passing ? "" : "\n") << std::flush;
    else
      std::cout << line << std::endl;
  }

  std::string title() const {
    const CameraSettings& camera = options_.camera;
    if (camera.source == "dataset") return "recording " + camera.dataset.folder;
    if (camera.source == "log") return "log " + camera.log.file;
    if (camera.is_live_kind()) return "camera by " + camera.source;
    const SimulationSettings& simulation = camera.simulation.simulation;
    return fmt::format("simulated {}, head {}, base {}, seed {}", simulation.scene.stem().string(),
                       simulation.head, simulation.base, simulation.seed);
  }

  void show_pictures() const {
    const char* display = std::getenv("DISPLAY");
    if (options_.headless || display == nullptr || *display == '\0') return;
    setenv("LCMSLAM_PICTURE", (options_.out + "/icp_front.png").c_str(), 1);  // the shell reads no name
    if (std::system("xdg-open \"$LCMSLAM_PICTURE\" > /dev/null 2>&1") != 0)
      std::cout << "  (no viewer for the pictures found)\n";
  }

  const DemoOptions& options_;
  LcmPublisher publisher_;
  Inputs inputs_;
  RunRecorder recorder_;
  Receiver receiver_;
  Supervisor supervisor_;
  PageWatch page_;
  RunFacts facts_;
  bool terminal_;
  double mapping_since_ = -1;
};

/// The user's bus, or a private one where there is none or another graph has it. Nothing where neither can be
/// had.
std::unique_ptr<LcmBus> open_bus(DemoOptions& options) {
  DoctorOptions doctor;
  doctor.lcm_url = options.lcm_url;
  doctor.processes = process_names();
  std::string reason = "no multicast route on this machine (sudo ip route add 224.0.0.0/4 dev lo  makes one)";
  std::string cure = "LCM cannot use " + options.lcm_url + "; try: sudo ip route add 224.0.0.0/4 dev lo";
  auto bus = std::make_unique<LcmBus>(options.lcm_url);
  if (bus->usable()) {
    const Finding senders = check_senders(doctor);
    if (!is_rival_graph(senders)) return bus;
    reason = cure = senders.text;
  }
  bus.reset();
  if (enter_private_bus()) {
    options.private_bus = true;
    options.overrides.insert(options.overrides.begin(), without_page);
    std::cout << "lcmslam demo: " << reason << "; runs on a private bus (lcm-spy cannot see it)\n";
    bus = std::make_unique<LcmBus>(options.lcm_url);
    if (bus->usable()) return bus;
  }
  std::cerr << "lcmslam demo: " << cure << "\n";
  return nullptr;
}

}  // namespace

int demo_command(int argc, char** argv) {
  DemoOptions options;
  if (const auto exit_code = parse(argc, argv, options)) return *exit_code;
  check_run_folder(options.out, options.force);
  complete(options);
  install_stop_signals(0);

  const auto bus = open_bus(options);
  if (!bus) return 1;
  make_folder(options);
  return Demo(options, *bus).run();
}

}  // namespace lcmslam
