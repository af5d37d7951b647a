#include "tools/study/faults/faults_study.hpp"

#include <fmt/format.h>
#include <chrono>
#include <cmath>
#include <iostream>
#include <stdexcept>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/evaluation/table.hpp>
#include "tools/study/faults/small_disk.hpp"

namespace lcmslam {
namespace {

constexpr int disk_megabytes = 300;
constexpr int undisturbed_runs = 3;  // of each scene: live no two are alike

struct Scene {
  std::string name, config;
  std::unique_ptr<CameraSource> (*open)(const FaultsStudySettings& settings);
  double seconds = 0;  // of its faults
};

/// Played from a log: rendering takes most of a processor, and who judges must not wait for it.
std::unique_ptr<CameraSource> open_kitchen(const FaultsStudySettings&) {
  SimulationSourceSettings settings;
  settings.simulation.scene = share_path("config/scenes/kitchen.yaml");
  settings.render = "cached";
  return make_simulation_source(settings);
}

std::unique_ptr<CameraSource> open_data_set(const FaultsStudySettings& study) {
  DatasetSourceSettings settings;
  settings.folder = study.recording;
  return make_dataset_source(settings);
}

FaultsStudyRun run_scene(const Scene& scene, std::uint64_t seed, std::vector<Fault> faults,
                         const FaultsStudySettings& settings, const std::filesystem::path& folder) {
  FaultsStudyRun run{scene.name, seed, std::move(faults), {}};
  FaultRunSettings graph;
  graph.config = share_path(scene.config);
  graph.lcm_url = settings.lcm_url;
  graph.folder =
      folder / (scene.name + "-" + (run.faults.empty() ? "undisturbed-" : "") + std::to_string(seed));
  graph.faults = run.faults;
  graph.seed = seed;
  const SmallDisk disk(graph.folder, disk_megabytes);
  std::cout << "lcmslam study: " << graph.folder.filename().string() << std::endl;
  run.result = run_with_faults(*scene.open(settings), graph);
  return run;
}

nlohmann::json mapper_json(const MapperOutcome& outcome) {
  return {{"ate_m", outcome.ate},
          {"poses", outcome.poses},
          {"sessions", outcome.sessions},
          {"false_tracking_s", outcome.false_tracking.seconds},
          {"false_tracking_m", outcome.false_tracking.error},
          {"maps_before", outcome.maps_before},
          {"map_kept", outcome.kept},
          {"map_kept_least_after", outcome.lost_after}};
}

/// "97 % of 3 (killed icp)": least share, of how many maps, and what had gone wrong.
std::string kept_words(const MapperOutcome& outcome) {
  if (outcome.maps_before == 0) return "-";
  const std::string cause = outcome.lost_after.empty() ? "" : " (" + outcome.lost_after + ")";
  return fmt::format("{:.0f} % of {}{}", 100 * outcome.kept, outcome.maps_before, cause);
}

std::string words(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) {
    text += text.empty() ? "" : ", ";
    text += to_string(fault.kind) + (fault.process.empty() ? "" : " " + fault.process);
  }
  return text.empty() ? "none" : text;
}

/// Who said what, and each pose against the truth: [s, 1 where it says TRACKING, m].
nlohmann::json record_json(const RunRecord& record) {
  nlohmann::json alarms = nlohmann::json::array();
  for (const Alarm& alarm : record.alarms) alarms.push_back({alarm.at, alarm.text});
  nlohmann::json json = {{"alarms", alarms}};
  for (const auto& [name, poses] : {std::pair("fastslam", &record.fastslam), {"icp", &record.icp}})
    for (const auto& pose : *poses) json[name].push_back({pose.at, pose.tracking ? 1 : 0, pose.error});
  return json;
}

}  // namespace

std::vector<FaultsStudyRun> study_faults(const FaultsStudySettings& settings,
                                         const std::filesystem::path& folder) {
  if (!own_mounts()) throw std::runtime_error("--only faults fills small disks of its own, which needs root");
  std::vector<Scene> scenes = {{"kitchen", "config/demo.yaml", open_kitchen, 40}};
  if (!settings.recording.empty()) scenes.push_back({"recording", "config/dataset.yaml", open_data_set, 26});
  const auto begin = std::chrono::steady_clock::now();
  const auto minutes = [&] {
    return std::chrono::duration<double, std::ratio<60>>(std::chrono::steady_clock::now() - begin).count();
  };
  std::vector<FaultsStudyRun> runs;
  for (const Scene& scene : scenes)
    for (int i = 0; i < undisturbed_runs; ++i)
      runs.push_back(run_scene(scene, settings.seed + static_cast<std::uint64_t>(i), {}, settings, folder));
  for (std::uint64_t i = 0; minutes() < settings.minutes; ++i) {
    const Scene& scene = scenes[i % scenes.size()];
    const std::uint64_t seed = settings.seed + i / scenes.size();
    runs.push_back(run_scene(scene, seed, fault_schedule(seed, scene.seconds), settings, folder));
  }
  return runs;
}

std::string responses_table(const std::vector<FaultsStudyRun>& runs) {
  Table table({"fault", "told after s", "by", "fastslam right after s", "m", "usual m", "worst usual m",
               "icp right after s", "m", "usual m", "worst usual m"});
  const auto seconds = [](const std::optional<double>& s) { return s ? fixed_number(*s, 2) : "-"; };
  for (const FaultsStudyRun& run : runs) {
    std::vector<RunRecord> usual;
    for (const FaultsStudyRun& other : runs)
      if (other.scene == run.scene && other.faults.empty()) usual.push_back(other.result.record);
    for (const FaultResponse& r : fault_responses(run.faults, run.result.record, usual)) {
      const std::string name = run.scene + ": " + words({r.fault});
      table.add({name, seconds(r.told), r.by.substr(0, 50), seconds(r.fastslam.found),
                 fixed_number(r.fastslam.error, 4), fixed_number(r.fastslam.usual, 4),
                 fixed_number(r.fastslam.worst, 4), seconds(r.icp.found), fixed_number(r.icp.error, 4),
                 fixed_number(r.icp.usual, 4), fixed_number(r.icp.worst, 4)});
    }
  }
  return table.text();
}

std::string faults_table(const std::vector<FaultsStudyRun>& runs) {
  Table table({"run", "mapper", "ATE m", "maps", "false TRACKING s", "m", "map kept", "told", "lost",
               "not judged", "stop s"});
  std::string faults;
  for (const FaultsStudyRun& run : runs) {
    const std::string name =
        run.scene + (run.faults.empty() ? " undisturbed " : " ") + std::to_string(run.seed);
    const KeptMap& map = run.result.map;
    for (const auto& [mapper, outcome, kept] : {std::tuple("fastslam", &run.result.fastslam, &map.landmarks),
                                                std::tuple("icp", &run.result.icp, &map.keyframes)})
      table.add({name, mapper, fixed_number(outcome->ate, 4), std::to_string(outcome->sessions),
                 fixed_number(outcome->false_tracking.seconds, 1),
                 fixed_number(outcome->false_tracking.error, 2), kept_words(*outcome),
                 std::to_string(kept->told), std::to_string(kept->lost), std::to_string(kept->unjudged),
                 fixed_number(run.result.stop_seconds, 1)});
    faults += name + ": " + words(run.faults) + "\n";
  }
  return table.text() + "\n" + faults + "\n" + responses_table(runs);
}

nlohmann::json run_json(const FaultsStudyRun& run) {
  nlohmann::json faults = nlohmann::json::array();
  for (const Fault& fault : run.faults)
    faults.push_back({{"kind", to_string(fault.kind)},
                      {"at_s", fault.at},
                      {"seconds", fault.seconds},
                      {"process", fault.process}});
  const KeptMap& map = run.result.map;
  return {{"scene", run.scene},
          {"seed", run.seed},
          {"faults", faults},
          {"fastslam", mapper_json(run.result.fastslam)},
          {"icp", mapper_json(run.result.icp)},
          {"stop_s", run.result.stop_seconds},
          {"sessions", map.sessions},
          {"sessions_joined", map.joined},
          {"keyframes_told", map.keyframes.told},
          {"keyframes_lost", map.keyframes.lost},
          {"keyframes_unjudged", map.keyframes.unjudged},
          {"keyframes_placed", map.placed},
          {"landmarks_told", map.landmarks.told},
          {"landmarks_lost", map.landmarks.lost},
          {"landmarks_unjudged", map.landmarks.unjudged},
          {"fastslam_gap_s", map.fastslam_gap},
          {"icp_gap_s", map.icp_gap},
          {"map_error_m", map.error},
          {"memory_bytes", run.result.memory},
          {"memory_bytes_of", run.result.memory_of},
          {"events", run.result.events}};
}

nlohmann::json faults_json(const std::vector<FaultsStudyRun>& runs) {
  nlohmann::json list = nlohmann::json::array();
  for (const FaultsStudyRun& run : runs) {
    list.push_back(run_json(run));
    list.back()["record"] = record_json(run.result.record);
  }
  return {{"runs", list}};
}

}  // namespace lcmslam
