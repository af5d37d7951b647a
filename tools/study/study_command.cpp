#include <fmt/format.h>
#include <sys/wait.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/evaluation/table.hpp>
#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/private_bus.hpp>
#include <lcmslam/runtime/version.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include "procs/camera/camera_log.hpp"
#include "tools/commands.hpp"
#include "tools/launch/graph.hpp"
#include "tools/parse_command.hpp"
#include "tools/run_folder.hpp"
#include "tools/study/consistency_study.hpp"
#include "tools/study/depth_filter_study.hpp"
#include "tools/study/endurance_command.hpp"
#include "tools/study/faults/faults_study.hpp"
#include "tools/study/feature_study.hpp"
#include "tools/study/filter_study.hpp"
#include "tools/study/landmark_study.hpp"
#include "tools/study/measures.hpp"
#include "tools/study/pair_study.hpp"
#include "tools/study/resampling_study.hpp"
#include "tools/study/study_report.hpp"

namespace lcmslam {
namespace {

const char* const path_names[] = {"odometry", "fastslam", "icp"};

/// One live run; its summary.json.
nlohmann::json run_demo(const std::vector<std::string>& arguments, const std::filesystem::path& folder) {
  std::string command =
      (program_folder() / "lcmslam").string() + " demo --headless --out '" + folder.string() + "'";
  for (const auto& argument : arguments) command += " '" + argument + "'";
  command += " > '" + (folder.string() + ".txt") + "' 2>&1";
  const int status = std::system(command.c_str());
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error("the run failed; see " + folder.string() + ".txt");
  std::ifstream file(folder / "summary.json");
  return nlohmann::json::parse(file);
}

double ate(const nlohmann::json& summary, const std::string& path) {
  return summary.at("paths").at(path).at("ate").at("translation_rmse_m").get<double>();
}

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
  const auto runs = study_consistency(logs, load_config(config, all), folder.string(), clock_offset);
  const auto scores = consistency_scores(runs);
  nlohmann::json report = consistency_json(runs, scores);
  report["set"] = overrides;
  write_report(folder, report, consistency_table(scores));
  return 0;
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

}  // namespace

int study_command(int argc, char** argv) {
  std::vector<int> seeds = {1, 2, 3, 4, 5};
  std::string config, data, only, description, scene;
  double seconds = 0;
  int robot = 0;
  std::vector<std::string> overrides;
  FeatureStudySettings features;
  CLI::App app{
      "Runs the demo live once for each seed and prints the errors of all runs. "
      "--only features: instead, how well features are found again and matched on a recording, ours beside "
      "dlib's SURF, SIFT and ORB. --only pairs: how often two clouds are registered without a start. "
      "--only landmarks: MRCLAM or Victoria Park in batch, once for each seed. --only filter: logs with "
      "images and truth through odometry and fastslam in batch, each with each seed. "
      "--only consistency: logs with truth (SCENE_SEED.lcmlog) in batch; whether both mappers err as much as "
      "their covariances say. "
      "--only depth-filter: mixed pixels removed and good points lost in simulated depth images. "
      "--only resampling: FastSLAM's four schemes on a log. "
      "--only faults: the live graph while stamps jump, processes die, the camera is covered, strangers send "
      "and the disk fills. "
      "--only endurance: memory, traffic and CPU of many laps of the kitchen in one process; ends with 0 "
      "only "
      "where they stay flat.",
      "lcmslam study"};
  app.add_option("--seeds,--seed", seeds, "of sensors and particles")->delimiter(',');
  app.add_option("--config", config, "as for the demo")->check(CLI::ExistingFile);
  app.add_option("--data", data, "a recording instead of the simulation (pairs: also a log)")
      ->check(CLI::ExistingPath);
  app.add_option("--seconds", seconds, "only the first so many seconds");
  app.add_option("--set", overrides, "override: section.key=value");
  const std::vector<std::string> studies = {"features",   "pairs",  "landmarks", "filter",     "depth-filter",
                                            "resampling", "faults", "endurance", "consistency"};
  const auto only_option =
      app.add_option("--only", only, "one study of its own: " + CLI::detail::join(studies, ", "))
          ->check(CLI::IsMember(studies));
  std::vector<std::string> logs;
  app.add_option("logs", logs, "filter, consistency: .lcmlog files")
      ->check(CLI::ExistingFile)
      ->needs(only_option);
  app.add_option("--scene", scene,
                 "filter: kitchen, table or office, which the logs show; for its true surfaces")
      ->needs(only_option);
  app.add_option("--robot", robot, "landmarks: which one of an MRCLAM folder")->needs(only_option);
  app.add_option("--description", description, "landmarks: of the data set, as for import")
      ->check(CLI::ExistingFile)
      ->needs(only_option);
  app.add_option("--apart", features.apart, "features: frames between the images of a pair, ascending")
      ->delimiter(',')
      ->needs(only_option)
      ->capture_default_str();
  app.add_option("--starts", features.starts, "features: first images, spread over the recording")
      ->needs(only_option)
      ->capture_default_str();
  app.add_option("--keypoints", features.keypoints, "features: at most, by response")
      ->needs(only_option)
      ->capture_default_str();
  PairStudySettings pairs;
  std::string method;
  app.add_option("--method", method, "pairs: only methods with this in their name")->needs(only_option);
  app.add_option("--max-translation", pairs.max_translation, "pairs: m, of a right result")
      ->needs(only_option)
      ->capture_default_str();
  app.add_option("--max-rotation", pairs.max_rotation, "pairs: degrees, of a right result")
      ->needs(only_option)
      ->capture_default_str();
  app.add_option("--clock-offset", pairs.truth_offset,
                 "pairs, consistency: s, added to images' stamps for the truth's clock")
      ->needs(only_option)
      ->capture_default_str();
  FaultsStudySettings faults;
  app.add_option("--minutes", faults.minutes, "faults: that the runs take together")
      ->needs(only_option)
      ->capture_default_str();
  int laps = 40;
  app.add_option("--laps", laps, "endurance: of the kitchen, about a minute each")
      ->check(CLI::Range(3, 1000))
      ->needs(only_option)
      ->capture_default_str();
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (only == "endurance") return endurance_command(laps, seeds.front(), config, overrides);
  if (only == "faults") {
    faults.recording = data;
    return run_faults_study(faults, seeds);
  }
  if (only == "pairs") {
    if (data.empty()) throw std::invalid_argument("--only pairs needs --data, a folder or a log");
    if (app.count("--apart") > 0) pairs.apart = features.apart;
    if (app.count("--starts") > 0) pairs.starts = features.starts;
    return run_pair_study(data, method, pairs);
  }
  if (only == "depth-filter") return run_depth_filter_study(seeds);
  if (only == "resampling") {
    if (data.empty()) throw std::invalid_argument("--only resampling needs --data LOG with GROUND_TRUTH");
    if (config.empty()) config = share_path("config/replay.yaml");
    return run_resampling_study({data, config, overrides, seeds});
  }
  if (only == "features") {
    if (data.empty()) throw std::invalid_argument("--only features needs --data FOLDER, a recording");
    return run_feature_study(data, features);
  }

  if (only == "filter") {
    if (logs.empty()) throw std::invalid_argument("--only filter needs logs");
    return run_filter_study(logs, scene, config, overrides, seeds);
  }
  if (only == "consistency") {
    if (logs.empty()) throw std::invalid_argument("--only consistency needs logs with GROUND_TRUTH");
    return run_consistency_study(logs, config, overrides, pairs.truth_offset);
  }
  if (only == "landmarks") {
    if (data.empty()) throw std::invalid_argument("--only landmarks needs --data FOLDER");
    return run_landmark_study(data, robot, config, description, overrides, seeds);
  }

  const std::filesystem::path folder = new_run_folder("study");
  Table table({"seed", "frames", "odometry ATE m", "fastslam ATE m", "icp ATE m", "icp frames", "lost"});
  std::map<std::string, std::vector<double>> errors;
  for (const int seed : seeds) {
    std::vector<std::string> arguments = {"--seed", std::to_string(seed)};
    if (!config.empty()) arguments.insert(arguments.end(), {"--config", config});
    if (!data.empty()) arguments.insert(arguments.end(), {"--data", data});
    if (seconds > 0) arguments.insert(arguments.end(), {"--seconds", std::to_string(seconds)});
    for (const auto& value : overrides) arguments.insert(arguments.end(), {"--set", value});
    const nlohmann::json summary = run_demo(arguments, folder / ("seed-" + std::to_string(seed)));
    std::vector<std::string> row = {std::to_string(seed),
                                    fmt::format("{:.0f}", summary.at("frames").get<double>())};
    for (const char* name : path_names) {
      errors[name].push_back(ate(summary, name));
      row.push_back(fixed_number(errors[name].back(), 4));
    }
    const auto& paths = summary.at("paths");
    row.push_back(std::to_string(paths.at("icp").at("poses").get<int>()));
    row.push_back(
        std::to_string(paths.at("icp").at("lost").get<int>() + paths.at("fastslam").at("lost").get<int>()));
    table.add(row);
    std::cout << "seed " << seed << ": done" << std::endl;
  }
  for (const bool worst : {false, true}) {
    std::vector<std::string> row = {worst ? "worst" : "median", ""};
    for (const char* name : path_names) {
      const auto& values = errors[name];
      row.push_back(
          fixed_number(worst ? *std::max_element(values.begin(), values.end()) : median(values), 4));
    }
    row.insert(row.end(), {"", ""});
    table.add(row);
  }
  std::cout << table.text() << "\nruns: " << folder.string() << "\n";
  return 0;
}

}  // namespace lcmslam
