#include "tools/study/own_studies.hpp"

#include <algorithm>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/private_bus.hpp>
#include <lcmslam/runtime/version.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include "procs/camera/camera_log.hpp"
#include "tools/run_folder.hpp"
#include "tools/study/consistency_study.hpp"
#include "tools/study/depth_filter_study.hpp"
#include "tools/study/endurance_command.hpp"
#include "tools/study/faults/kills_study.hpp"
#include "tools/study/filter_study.hpp"
#include "tools/study/landmark_study.hpp"
#include "tools/study/resampling_study.hpp"
#include "tools/study/study_report.hpp"

namespace lcmslam {
namespace {

/// A recording: a data set's folder or a log.
std::unique_ptr<CameraSource> open_recording(const std::string& path) {
  if (!std::filesystem::is_directory(path)) return open_log(path);
  DatasetSourceSettings settings;
  settings.folder = path;
  return make_dataset_source(settings);
}

int run_pair_study(const std::string& data, const std::string& wanted, const PairStudySettings& settings) {
  const auto source = open_recording(data);
  std::vector<PairMethod> methods;
  for (PairMethod& method : pair_methods())
    if (method.name.find(wanted) != std::string::npos) methods.push_back(std::move(method));
  if (methods.empty()) throw std::invalid_argument("no method's name has '" + wanted + "' in it");
  const PairStudyResult result = study_pairs(*source, methods, settings);
  nlohmann::json report = pair_json(result, settings);
  report["data"] = data;
  write_report(new_run_folder("study-pairs"), report, pair_table(result));
  return 0;
}

/// The configuration that belongs to a recording of landmarks, unless another is named.
int run_landmark_study(const std::string& data, int robot, std::string config, const std::string& description,
                       const std::vector<std::string>& overrides, const std::vector<int>& seeds) {
  DatasetOptions options;
  options.description = description;
  const auto recording = open_landmark_dataset(data, robot, options);
  if (!recording) throw std::invalid_argument(data + " is neither an MRCLAM folder nor Victoria Park");
  if (config.empty())
    config = share_path(recording->twists.empty() ? "config/victoria_park.yaml" : "config/mrclam.yaml");
  const LandmarkStudyResult result = study_landmarks(*recording, load_config(config, overrides), seeds);
  nlohmann::json report = landmark_json(result);
  report["data"] = data;
  report["robot"] = robot;
  write_report(new_run_folder("study-landmarks"), report, landmark_table(result));
  return 0;
}

int run_filter_study(const std::vector<std::string>& logs, const std::string& scene, std::string config,
                     const std::vector<std::string>& overrides, const std::vector<int>& seeds) {
  std::unique_ptr<Simulation> simulation;
  SurfaceDistance surface;
  if (!scene.empty()) {
    SimulationSettings settings;
    settings.scene = share_path("config/scenes/" + scene + ".yaml");
    simulation = std::make_unique<Simulation>(settings);
    surface = [&](const Eigen::Vector3d& point) { return simulation->distance_to_surface(point); };
  }
  if (config.empty()) config = share_path("config/replay.yaml");
  const auto scores = study_filter(logs, load_config(config, overrides), seeds, surface);
  nlohmann::json report = filter_json(scores);
  report["set"] = overrides;
  write_report(new_run_folder("study-filter"), report, filter_table(scores));
  return 0;
}

int run_consistency_study(const std::vector<std::string>& logs, std::string config,
                          const std::vector<std::string>& overrides, double clock_offset) {
  if (config.empty()) config = share_path("config/replay.yaml");
  std::vector<std::string> all = {"launch.processes=[surf, odometry, fastslam, icp]"};
  all.insert(all.end(), overrides.begin(), overrides.end());
  const std::filesystem::path folder = new_run_folder("study-consistency");
  const auto judged = study_consistency(logs, load_config(config, all), folder.string(), clock_offset);
  const auto scores = consistency_scores(judged.runs);
  nlohmann::json report = consistency_json(judged.runs, scores);
  report["set"] = overrides;
  report["left_out"] = judged.left_out;
  write_report(folder, report,
               consistency_table(scores) + "\nErrors within three of their sigmas (99.7 % when honest)\n" +
                   within_table(scores));
  for (const std::string& log : judged.left_out) std::cout << "left out: " << log << "\n";
  return judged.left_out.empty() ? 0 : 1;
}

int run_depth_filter_study(const std::vector<int>& seeds) {
  DepthFilterStudySettings settings;
  settings.seed = static_cast<std::uint64_t>(seeds.front());
  for (const char* scene : {"kitchen.yaml", "table.yaml", "office.yaml"})
    settings.scenes.push_back(share_path("config/scenes") / scene);
  const DepthFilterStudyResult result = study_depth_filter(depth_filter_methods(), settings);
  write_report(new_run_folder("study-depth-filter"), depth_filter_json(result, settings),
               depth_filter_table(result));
  return 0;
}

int run_feature_study(const std::string& data, const FeatureStudySettings& settings) {
  settings.check();
  const auto source = open_dataset(data);
  FeatureMethods methods = all_feature_methods(settings.keypoints);
  const FeatureStudyResult result = study_features(*source, methods, settings);
  const std::filesystem::path folder = new_run_folder("study-features");
  write_atomically(folder / "features.csv", feature_csv(result));
  nlohmann::json report = feature_json(result, settings);
  report["data"] = data;
  report["version"] = lcmslam_version;
  write_atomically(folder / "features.json", report.dump(2) + "\n");
  std::cout << feature_table(result) << "\n" << (folder / "features.json").string() << ", features.csv\n";
  return 0;
}

int run_resampling_study(const ResamplingStudySettings& settings) {
  const std::filesystem::path folder = new_run_folder("study-resampling");
  const std::vector<ResamplingScore> scores = study_resampling(settings, folder);
  nlohmann::json report = resampling_json(scores);
  report["data"] = settings.log.string();
  write_report(folder, report, resampling_table(scores));
  return 0;
}

/// On a bus and a disk of its own.
int run_faults_study(FaultsStudySettings settings, const std::vector<int>& seeds) {
  settings.seed = static_cast<std::uint64_t>(seeds.front());
  settings.lcm_url = lcm_url_from_environment();
  if (!enter_private_bus()) throw std::runtime_error("--only faults needs a network namespace of its own");
  const std::filesystem::path folder = new_run_folder("study-faults");
  const std::filesystem::path disk = folder / "runs";
  std::filesystem::create_directories(disk);
  const std::vector<FaultsStudyRun> runs = study_faults(settings, disk);
  write_report(folder, faults_json(runs), faults_table(runs));
  return 0;
}

int run_kills_study(FaultsStudySettings settings, const std::vector<int>& seeds) {
  settings.seed = static_cast<std::uint64_t>(seeds.front());
  settings.lcm_url = lcm_url_from_environment();
  const std::filesystem::path folder = std::filesystem::absolute(new_run_folder("study-kills"));
  const nlohmann::json report = study_kills(settings, folder);
  write_report(folder, report, kills_table(report));
  return 0;
}

}  // namespace

const std::vector<std::string>& own_studies() {
  static const std::vector<std::string> names = {"features",     "pairs",      "landmarks", "filter",
                                                 "depth-filter", "resampling", "faults",    "endurance",
                                                 "consistency",  "kills"};
  return names;
}

int run_own_study(const std::string& name, OwnStudyOptions o) {
  const auto need = [&](bool given, const std::string& what) {
    if (!given) throw std::invalid_argument("--only " + name + " needs " + what);
  };
  if (name == "endurance") return endurance_command(o.laps, o.seeds.front(), o.config, o.overrides);
  if (name == "faults") {
    o.faults.recording = o.data;
    return run_faults_study(o.faults, o.seeds);
  }
  if (name == "kills") return run_kills_study(o.faults, o.seeds);
  if (name == "depth-filter") return run_depth_filter_study(o.seeds);
  if (name == "pairs") {
    need(!o.data.empty(), "--data, a folder or a log");
    return run_pair_study(o.data, o.method, o.pairs);
  }
  if (name == "resampling") {
    need(!o.data.empty(), "--data LOG with GROUND_TRUTH");
    if (o.config.empty()) o.config = share_path("config/replay.yaml");
    return run_resampling_study({o.data, o.config, o.overrides, o.seeds});
  }
  if (name == "features") {
    need(!o.data.empty(), "--data FOLDER, a recording");
    return run_feature_study(o.data, o.features);
  }
  if (name == "filter") {
    need(!o.logs.empty(), "logs");
    return run_filter_study(o.logs, o.scene, o.config, o.overrides, o.seeds);
  }
  if (name == "consistency") {
    need(!o.logs.empty(), "logs with GROUND_TRUTH");
    return run_consistency_study(o.logs, o.config, o.overrides, o.pairs.truth_offset);
  }
  if (name == "landmarks") {
    need(!o.data.empty(), "--data FOLDER");
    return run_landmark_study(o.data, o.robot, o.config, o.description, o.overrides, o.seeds);
  }
  throw std::logic_error("no study is called " + name);
}

}  // namespace lcmslam
