#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <iostream>
#include <thread>

#include <lcmslam/configuration/config_json.hpp>
#include <lcmslam/evaluation/table.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/runtime/machine.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/batch/batch_progress.hpp"
#include "tools/batch/batch_run.hpp"
#include "tools/commands.hpp"
#include "tools/demo/run_summary.hpp"
#include "tools/farm/batch_farm.hpp"
#include "tools/farm/farm_results.hpp"
#include "tools/output_file.hpp"
#include "tools/parse_command.hpp"
#include "tools/run_folder.hpp"

namespace lcmslam {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Whether the map server has saved maps.
bool saved_maps(const BatchResult& result) {
  return std::any_of(result.processes.begin(), result.processes.end(), [](const auto& process) {
    const auto& values = process.report.values;
    return std::any_of(values.begin(), values.end(),
                       [](const auto& v) { return v.first == "saved" && v.second > 0; });
  });
}

void print(const BatchResult& result, const std::string& errors, double seconds) {
  std::cout << fmt::format("{} frames, {:.1f} s of log in {:.1f} s: {:.2f} x real time, {:.1f} s CPU\n\n",
                           result.frames, result.log_seconds, seconds, result.log_seconds / seconds,
                           process_cpu_seconds());
  // Of the handlers alone: what works beside them and saves maps at the end is in the sum above.
  const double frames = static_cast<double>(std::max<std::int64_t>(result.frames, 1));
  Table table({"process", "received", "malformed", "published", "CPU ms a frame"});
  for (const auto& process : result.processes)
    table.add({process.process, std::to_string(process.received), std::to_string(process.decode_errors),
               std::to_string(process.published), fmt::format("{:.2f}", 1e3 * process.cpu_seconds / frames)});
  std::cout << table << "\n";
  for (const auto& process : result.processes) {
    std::cout << process.process << ":";
    for (const auto& [name, value] : process.report.values)
      std::cout << fmt::format("  {} {:g}", name, value);
    std::cout << "\n";
    if (!process.report.detail.empty()) std::cout << "  " << process.report.detail << "\n";
  }
  std::cout << "\n" << errors << (errors.empty() ? "" : "\n");
  if (result.damages > 0)
    std::cout << "the log is damaged in " << result.damages << " places (lcmslam log check)\n";
  if (result.incomplete > 0) std::cout << result.incomplete << " messages in pieces were incomplete\n";
  std::cout << "results: " << result.output.string() << " (" << result.published << " messages), "
            << (saved_maps(result) ? "maps beside it" : "no map was saved") << "\n";
}

/// Runs with progress; a stop or an error takes a new folder away again unless something stands in it.
BatchResult run(const BatchOptions& asked, const BatchPlan& plan, bool new_folder) {
  BatchOptions options = asked;
  const Clock::time_point begin = Clock::now();
  ProgressLine line(std::cout, isatty(STDOUT_FILENO) != 0);
  options.progress = [&](std::int64_t frame) {
    throw_when_stopped();
    line.show(seconds_since(begin), frame, plan.frames);
  };
  try {
    BatchResult result = run_batch(options, plan);
    line.clear();
    return result;
  } catch (...) {
    line.clear();
    std::error_code ignored;
    if (new_folder) std::filesystem::remove(options.folder, ignored);
    throw;
  }
}

/// Trajectories, pictures and summary.json beside the maps, as after a live run.
void write_files(const BatchResult& result, RunRecorder& recorder, Inputs& inputs, const RunFacts& facts) {
  for (const auto& process : result.processes) {
    status_t status{};
    status.process = process.process;
    status.state = static_cast<int8_t>(process.report.state);
    status.detail = process.report.detail;
    for (const auto& [name, value] : process.report.values) {
      value_t v;
      v.name = name;
      v.value = value;
      status.values.push_back(v);
    }
    status.n_values = static_cast<int32_t>(status.values.size());
    const auto bytes = encode_message(status);
    inputs.deliver("STATUS", bytes.data(), bytes.size());
  }
  write_run_files(result.output.parent_path(), recorder, facts);
}

struct BatchArguments {
  FarmArguments farm;  // the logs, and how several are run
  std::string key;
};

int run_one(const BatchArguments& arguments) {
  const FarmArguments& asked = arguments.farm;
  BatchOptions options;
  RunFacts facts;
  options.threads = asked.threads;
  options.from = asked.from;
  options.to = asked.to;
  options.config = load_config(asked.config, asked.overrides);
  facts.configuration = config_json(asked.config);
  if (!arguments.key.empty() && arguments.key != farm_key(asked, asked.logs.front()))
    throw std::runtime_error(
        "the log, the configuration or this program is not what it was when the farm began: "
        "run that again");
  options.log = asked.logs.front();
  const Expectations expectations = asked.expect.empty() ? Expectations() : Expectations(asked.expect);
  check_run_folder(asked.out, asked.force);
  if (!asked.calibration.empty()) {
    options.calibration = load_calibration(asked.calibration);
    std::cout << "calibration: " << asked.calibration << ": " << describe(*options.calibration) << "\n";
  }
  const BatchPlan plan = plan_batch(options);
  for (const auto& note : plan.notes) std::cout << note << "\n";
  std::cout << std::flush;
  const bool new_folder = asked.out.empty() || !std::filesystem::exists(asked.out);
  options.folder = asked.out.empty() ? new_run_folder("batch") : std::filesystem::path(asked.out);

  const Clock::time_point begin = Clock::now();
  Inputs inputs;
  RunRecorder recorder(inputs);
  options.heard = [&inputs](const BatchMessage& message) {
    inputs.deliver(message.channel, message.bytes.data(), message.bytes.size());
  };
  const BatchResult result = run(options, plan, new_folder);
  print(result, format_errors(recorder), seconds_since(begin));
  facts.title = "log " + asked.logs.front();
  facts.config = asked.config;
  facts.overrides = asked.overrides;
  facts.frames = static_cast<double>(result.frames);
  facts.seconds = seconds_since(begin);
  facts.kitti = asked.kitti;
  facts.key = arguments.key;
  const std::vector<std::string> problems = problems_of(result);
  facts.events = problems;
  write_files(result, recorder, inputs, facts);
  for (const auto& problem : problems) std::cerr << "lcmslam batch: " << problem << "\n";
  if (problems.size() > 1)
    std::cerr << "lcmslam batch: " << asked.logs.front() << ": first: " << problems.front() << "\n";
  if (!problems.empty() || asked.expect.empty()) return problems.empty() ? 0 : 1;
  const FarmResult reached = read_result(options.folder, expectations);
  for (const auto& failure : reached.failures) std::cerr << "lcmslam batch: " << failure << "\n";
  return reached.passed() ? 0 : 1;
}

}  // namespace

int batch_command(int argc, char** argv) {
  BatchArguments arguments;
  FarmArguments& asked = arguments.farm;
  asked.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  CLI::App app{
      "Runs the whole graph in one process straight from a log: nothing dropped, the same result on "
      "every run. Several logs: each in a process and a folder of its own below --out; what is there "
      "already, of "
      "the same log, configuration and build, is not run again. Exit code 0: passed; 1: below --expect, or "
      "nothing was mapped; 2: bad input.",
      "lcmslam batch"};
  app.add_option("config", asked.config, "configuration (YAML), e.g. config/replay.yaml")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option(  // farm_problem() looks whether they are there: so that a mistyped option is named first
      "log", asked.logs,
      ".lcmlog with CAMERA, CAMERA_CALIBRATION (or --calibration) and, if there is other odometry than "
      "the camera's, ENCODERS, TWIST or a pose; or with FEATURES");
  app.add_option("--calibration", asked.calibration,
                 "calibration (YAML) in the place of the log's: ours, ROS's camera_info or OpenCV's")
      ->check(CLI::ExistingFile);
  app.add_option("--out", asked.out,
                 "folder for batch.lcmlog, maps, trajectories, pictures and summary.json, default "
                 "out/batch-TIME; of several logs a folder each in it");
  app.add_flag("--force", asked.force, "overwrite another run's results in that folder");
  app.add_option("--from", asked.from, "s from the log's start")->check(CLI::NonNegativeNumber);
  app.add_option("--to", asked.to, "s from the log's start")->check(CLI::NonNegativeNumber);
  app.add_option("--threads", asked.threads, "does not change the result")->check(CLI::Range(1, 256));
  app.add_flag("--kitti", asked.kitti, "trajectories in KITTI's format too");
  app.add_option("--set", asked.overrides, "override: section.key=value");
  app.add_option("--expect", asked.expect, "bars that each log must reach (YAML): {icp: {ate: 0.02}, ...}")
      ->check(CLI::ExistingFile);
  app.add_option("--list", asked.list, "file that names logs, one a line, in the place of arguments")
      ->check(CLI::ExistingFile);
  app.add_option("--jobs", asked.jobs, "logs at a time (default: as many as processors)")
      ->check(CLI::Range(1, 256));
  app.add_option("--share", asked.share, "K/N: only every N-th log, from the K-th; for several machines");
  app.add_flag("--slurm", asked.slurm, "hand the logs to Slurm as a job array and come back at once");
  app.add_option("--pack", asked.pack, "with --slurm: logs a job")->check(CLI::Range(1, 100000));
  app.add_option("--key", arguments.key, "written into summary.json: how a farm knows its own results");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (asked.to > 0 && asked.to <= asked.from) {
    std::cerr << fmt::format("lcmslam batch: --to {} must be later than --from {}\n", asked.to, asked.from);
    return 2;
  }
  keep_freed_memory();
  install_stop_signals(0);
  if (const auto problem = farm_problem(asked)) {
    std::cerr << "lcmslam batch: " << *problem << "\n";
    return 2;
  }
  if (!is_farm(asked)) return run_one(arguments);
  return batch_farm(asked, std::cout);
}

}  // namespace lcmslam
