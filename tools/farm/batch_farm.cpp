#include "tools/farm/batch_farm.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <sstream>
#include <thread>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tools/farm/farm.hpp"
#include "tools/farm/run_key.hpp"
#include "tools/farm/slurm.hpp"
#include "tools/launch/graph.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

std::string whole(const std::string& path) {
  return fs::absolute(path).string();
}

std::vector<FarmJob> jobs_of(const FarmArguments& arguments) {
  std::vector<fs::path> logs(arguments.logs.begin(), arguments.logs.end());
  if (!arguments.list.empty()) logs = read_log_list(arguments.list);
  return farm_jobs(logs);
}

/// What every run is told alike. Overrides stand last: their option takes all that follows.
std::vector<std::string> options_of(const FarmArguments& arguments) {
  std::vector<std::string> words;
  if (arguments.kitti) words.push_back("--kitti");
  if (!arguments.calibration.empty())
    words.insert(words.end(), {"--calibration", whole(arguments.calibration)});
  if (arguments.from > 0) words.insert(words.end(), {"--from", fmt::format("{}", arguments.from)});
  if (arguments.to > 0) words.insert(words.end(), {"--to", fmt::format("{}", arguments.to)});
  for (const std::string& text : arguments.overrides) words.insert(words.end(), {"--set", text});
  return words;
}

std::vector<std::string> program() {
  return {(program_folder() / "lcmslam-tools").string(), "batch"};
}

int hand_over_to_slurm(const FarmArguments& arguments, const std::vector<FarmJob>& jobs, std::ostream& out) {
  const fs::path folder = fs::absolute(arguments.out);
  std::string list;
  for (const FarmJob& job : jobs) list += job.log.string() + "\n";
  write_atomically(FilePlace(folder / "logs.txt"), list);
  SlurmArray array;
  array.folder = folder;
  array.processors = std::max(1, arguments.jobs);
  array.tasks = (static_cast<int>(jobs.size()) + arguments.pack - 1) / arguments.pack;
  array.command = program();
  const std::string jobs_at_a_time = std::to_string(array.processors);
  array.command.insert(array.command.end(),
                       {whole(arguments.config), "--list", (folder / "logs.txt").string(), "--out",
                        folder.string(), "--jobs", jobs_at_a_time});
  if (!arguments.expect.empty())
    array.command.insert(array.command.end(), {"--expect", whole(arguments.expect)});
  if (arguments.force) array.command.push_back("--force");
  // Before the options that take all that follows.
  const std::vector<std::string> options = options_of(arguments);
  array.command.insert(array.command.begin() + 3, options.begin(), options.end());
  out << submit(array)
      << fmt::format("\n{} logs in {} jobs; when they have ended: lcmslam collect {}\n", jobs.size(),
                     array.tasks, arguments.out);
  return 0;
}

void keep_expectations(const FarmArguments& arguments) {
  if (arguments.expect.empty()) return;
  std::ostringstream text;
  text << std::ifstream(arguments.expect).rdbuf();
  write_atomically(FilePlace(fs::path(arguments.out) / "expect.yaml"), text.str());
}

}  // namespace

bool is_farm(const FarmArguments& arguments) {
  return arguments.logs.size() > 1 || !arguments.list.empty() || !arguments.share.empty() ||
         arguments.slurm || arguments.jobs > 0;
}

std::optional<std::string> farm_problem(const FarmArguments& arguments) {
  if (arguments.logs.empty() == arguments.list.empty())
    return arguments.list.empty() ? "log is required: name one or several, or --list FILE"
                                  : "logs are named by --list and as arguments: one of both";
  for (const std::string& log : arguments.logs) {
    if (fs::is_directory(log)) return "log: is a folder, not a file: " + log;
    if (!fs::exists(log)) return "log: file does not exist: " + log;
  }
  if (is_farm(arguments) && arguments.out.empty())
    return "several logs need --out FOLDER: the same folder again goes on where a run was stopped";
  if (arguments.slurm && !arguments.share.empty()) return "--slurm makes the shares itself: without --share";
  return std::nullopt;
}

std::string farm_key(const FarmArguments& arguments, const fs::path& log) {
  return run_key({log, arguments.config, arguments.overrides, arguments.calibration, arguments.from,
                  arguments.to, arguments.kitti});
}

int batch_farm(const FarmArguments& arguments, std::ostream& out) {
  load_config(arguments.config, arguments.overrides);  // what cannot be read is refused before any work
  FarmOptions farm;
  farm.folder = arguments.out;
  if (!arguments.expect.empty()) farm.expectations = Expectations(arguments.expect);
  farm.jobs = jobs_of(arguments);
  fs::create_directories(farm.folder);
  keep_expectations(arguments);
  if (arguments.slurm) return hand_over_to_slurm(arguments, farm.jobs, out);
  if (!arguments.share.empty()) farm.jobs = share_of(farm.jobs, parse_share(arguments.share));

  const int processors = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  farm.at_a_time = arguments.jobs > 0 ? arguments.jobs : processors;
  const int threads = std::max(1, processors / farm.at_a_time);
  farm.force = arguments.force;
  farm.key = [&](const FarmJob& job) { return farm_key(arguments, job.log); };
  farm.command = [&](const FarmJob& job, const fs::path& folder, const std::string& key) {
    std::vector<std::string> words = program();
    words.insert(words.end(), {arguments.config, job.log.string(), "--out", folder.string(), "--force",
                               "--key", key, "--threads", std::to_string(threads)});
    const std::vector<std::string> options = options_of(arguments);
    words.insert(words.end(), options.begin(), options.end());
    return words;
  };
  const std::vector<FarmResult> results = run_farm(farm, out);
  const auto passed =
      std::count_if(results.begin(), results.end(), [](const FarmResult& r) { return r.passed(); });
  out << fmt::format("{} of {} passed; lcmslam collect {} shows all\n", passed, results.size(),
                     arguments.out);
  return exit_code_of(results);
}

}  // namespace lcmslam
