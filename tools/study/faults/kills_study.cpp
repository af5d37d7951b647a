#include "tools/study/faults/kills_study.hpp"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <stdexcept>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/evaluation/median.hpp>
#include <lcmslam/evaluation/table.hpp>
#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/runtime/private_bus.hpp>

namespace lcmslam {
namespace {

constexpr double apart = 30;         // s
constexpr double shortest_lap = 45;  // s
const std::vector<std::string> run_names = {"undisturbed", "killed"};

/// As many as `minutes` take; rendered once, then played from a log.
std::unique_ptr<CameraSource> open_laps(const FaultsStudySettings& study) {
  SimulationSourceSettings settings;
  settings.simulation.scene = share_path("config/scenes/kitchen.yaml");
  settings.simulation.laps = 1 + static_cast<int>(std::ceil(60 * study.minutes / shortest_lap));
  settings.simulation.seconds = 60 * study.minutes;
  settings.render = "cached";
  return make_simulation_source(settings);
}

/// s without any of these times, the longest in [from, to).
double silence(const std::vector<double>& times, double from, double to) {
  double longest = 0, last = from;
  for (const double at : times) {
    if (at < from || at >= to) continue;
    longest = std::max(longest, at - last);
    last = at;
  }
  return std::max(longest, to - last);
}

std::vector<double> told_at(const std::vector<MapperWatch::Held>& poses) {
  std::vector<double> times;
  times.reserve(poses.size());
  for (const auto& pose : poses) times.push_back(pose.at);
  return times;
}

/// s after the drive's begin.
std::vector<double> measured_at(const std::vector<Utime>& poses, Utime begun) {
  std::vector<double> times;
  times.reserve(poses.size());
  for (const Utime utime : poses) times.push_back(1e-6 * static_cast<double>(utime - begun));
  return times;
}

/// What each kill did until the next one.
nlohmann::json kills_json(const FaultsStudyRun& run) {
  nlohmann::json kills = nlohmann::json::array();
  const RunRecord& record = run.result.record;
  const KeptMap& map = run.result.map;
  const auto fastslam = told_at(record.fastslam), icp = told_at(record.icp);
  const auto fastslam_kept = measured_at(map.fastslam_poses, run.result.begun);
  const auto icp_kept = measured_at(map.icp_poses, run.result.begun);
  for (const FaultResponse& response : fault_responses(run.faults, record, {record})) {
    const double from = response.fault.at, to = from + apart - 4;  // kills are up to 4 s nearer
    nlohmann::json kill = {{"process", response.fault.process},
                           {"at_s", from},
                           {"fastslam_silent_s", silence(fastslam, from, to)},
                           {"icp_silent_s", silence(icp, from, to)},
                           // What waited to be written is lost with the map server: a second before, too.
                           {"fastslam_not_kept_s", silence(fastslam_kept, from - 1, to)},
                           {"icp_not_kept_s", silence(icp_kept, from - 1, to)}};
    if (response.told) kill["told_s"] = *response.told;
    if (response.fastslam.found) kill["fastslam_right_s"] = *response.fastslam.found;
    if (response.icp.found) kill["icp_right_s"] = *response.icp.found;
    kills.push_back(kill);
  }
  return kills;
}

nlohmann::json run_laps(const std::string& name, const FaultsStudySettings& settings,
                        const std::filesystem::path& folder) {
  const double seconds = 60 * settings.minutes;
  FaultRunSettings graph;
  graph.config = share_path("config/demo.yaml");
  graph.lcm_url = settings.lcm_url;
  graph.folder = folder / name;
  if (name == "killed") graph.faults = kill_schedule(settings.seed, seconds, apart);
  graph.seed = settings.seed;
  graph.laid_until = apart - 2;  // the first kill at the earliest
  graph.export_before = false;
  std::filesystem::create_directories(graph.folder);
  const FaultsStudyRun run{"kitchen laps", settings.seed, graph.faults,
                           run_with_faults(*open_laps(settings), graph)};
  nlohmann::json report = run_json(run);
  report["run"] = name;
  report["kills"] = kills_json(run);
  return report;
}

/// In a process of its own, whose network is.
pid_t begin_run(const std::string& name, const FaultsStudySettings& settings,
                const std::filesystem::path& folder) {
  const pid_t pid = fork();
  if (pid < 0) throw std::runtime_error("no process for the run " + name);
  if (pid > 0) return pid;
  int code = 1;
  try {
    if (!enter_private_bus()) throw std::runtime_error("--only kills needs network namespaces of its own");
    write_atomically(folder / (name + ".json"), run_laps(name, settings, folder).dump(2) + "\n");
    code = 0;
  } catch (const std::exception& error) {
    std::cerr << "lcmslam study: " << name << ": " << error.what() << std::endl;
  }
  _exit(code);
}

nlohmann::json result_of(const std::string& name, pid_t pid, const std::filesystem::path& folder) {
  int status = 0;
  if (waitpid(pid, &status, 0) != pid || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error("the run " + name + " did not come to its end; see " + (folder / name).string());
  return nlohmann::json::parse(std::ifstream(folder / (name + ".json")));
}

/// Of each quarter the largest, MB.
std::string memory_words(const std::vector<double>& minutes) {
  std::string words;
  for (std::size_t quarter = 0; quarter < 4; ++quarter) {
    const auto at = [&](std::size_t n) { return static_cast<std::ptrdiff_t>(n * minutes.size() / 4); };
    const auto begin = minutes.begin() + at(quarter), end = minutes.begin() + at(quarter + 1);
    if (begin < end)
      words += fmt::format("{}{:.0f}", quarter > 0 ? ", " : "", 1e-6 * *std::max_element(begin, end));
  }
  return words;
}

/// Of `kills`; those without a value are the longest of all, and said.
std::string median_and_most(std::vector<double> values, std::size_t kills) {
  const std::size_t had = values.size();
  values.resize(std::max(had, kills), std::numeric_limits<double>::infinity());
  const auto word = [](double seconds) {
    return std::isfinite(seconds) ? fmt::format("{:.2f}", seconds) : std::string("never");
  };
  const std::string both =
      word(median(values)) + " / " + word(*std::max_element(values.begin(), values.end()));
  return had < kills ? fmt::format("{} ({} of {})", both, had, kills) : both;
}

/// Of each process that was killed.
std::string processes_table(const nlohmann::json& kills) {
  const std::vector<std::string> figures = {"told_s",           "fastslam_silent_s", "icp_silent_s",
                                            "fastslam_right_s", "icp_right_s",       "fastslam_not_kept_s",
                                            "icp_not_kept_s"};
  std::map<std::string, std::map<std::string, std::vector<double>>> values;
  std::map<std::string, int> counts;
  for (const auto& kill : kills) {
    const std::string process = kill["process"];
    ++counts[process];
    for (const std::string& figure : figures)
      if (kill.contains(figure)) values[process][figure].push_back(kill[figure]);
  }
  Table table({"killed", "times", "told after s", "fastslam silent s", "icp silent s",
               "fastslam right after s", "icp right after s", "fastslam not kept s", "icp not kept s"});
  for (const auto& [process, kills_of] : counts) {
    std::vector<std::string> row = {process, std::to_string(kills_of)};
    for (const std::string& figure : figures)
      row.push_back(median_and_most(values[process][figure], static_cast<std::size_t>(kills_of)));
    table.add(row);
  }
  return table.text();
}

/// Of each process, MB by quarters.
std::string memory_table(const nlohmann::json& runs) {
  Table table({"memory MB, by quarters", "undisturbed", "killed"});
  std::map<std::string, std::map<std::string, std::string>> words;  // by process and run
  for (const auto& run : runs)
    for (const auto& [process, minutes] : run["memory_bytes_of"].items())
      words[process][run["run"]] = memory_words(minutes.get<std::vector<double>>());
  for (auto& [process, of] : words) table.add({process, of["undisturbed"], of["killed"]});
  return table.text();
}

}  // namespace

nlohmann::json study_kills(const FaultsStudySettings& settings, const std::filesystem::path& folder) {
  open_laps(settings);  // rendered before both ask for it
  std::map<std::string, pid_t> runs;
  for (const std::string& name : run_names) runs[name] = begin_run(name, settings, folder);
  nlohmann::json results = nlohmann::json::array();
  for (const std::string& name : run_names) results.push_back(result_of(name, runs[name], folder));
  return {{"minutes", settings.minutes}, {"seed", settings.seed}, {"runs", results}};
}

std::string kills_table(const nlohmann::json& report) {
  Table table({"run", "killed", "sessions", "joined", "keyframes told", "lost", "not judged",
               "landmarks told", "lost", "not judged", "no pose kept for s: fastslam", "icp", "placed",
               "error m", "memory MB, by quarters", "stop s"});
  std::string processes;
  for (const auto& run : report["runs"]) {
    const auto count = [&](const char* name) { return std::to_string(run[name].get<int>()); };
    const auto figure = [&](const char* name, int digits) {
      return run[name].is_number() ? fixed_number(run[name].get<double>(), digits) : "-";
    };
    table.add({run["run"].get<std::string>(), std::to_string(run["faults"].size()), count("sessions"),
               count("sessions_joined"), count("keyframes_told"), count("keyframes_lost"),
               count("keyframes_unjudged"), count("landmarks_told"), count("landmarks_lost"),
               count("landmarks_unjudged"), figure("fastslam_gap_s", 2), figure("icp_gap_s", 2),
               count("keyframes_placed"), figure("map_error_m", 4),
               memory_words(run["memory_bytes"].get<std::vector<double>>()), figure("stop_s", 1)});
    if (!run["kills"].empty()) processes = processes_table(run["kills"]);
  }
  return table.text() +
         "\nof each kill until the next one, median / most; never (n of N): after n of N kills alone.\n"
         "A mapper that is killed begins a map, which is laid on the truth by its own first pose:\n"
         "\"right after\" says of itself when it spoke again, and of the other mapper where it was\n" +
         processes + "\n" + memory_table(report["runs"]);
}

}  // namespace lcmslam
