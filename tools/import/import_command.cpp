#include <fmt/format.h>
#include <iostream>

#include "procs/camera/camera_log.hpp"
#include "procs/camera/repeated_source.hpp"
#include "tools/commands.hpp"
#include "tools/import/landmark_log.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

int write(CameraSource& source, const std::string& log) {
  for (const auto& note : source.notes()) std::cout << "  " << note << "\n";
  const LogCounts counts = write_log(source, log);
  std::cout << fmt::format("  {}: {} frames, {} encoder readings, {} true poses, {:.1f} MB\n", log,
                           counts.frames, counts.encoders, counts.truths,
                           static_cast<double>(counts.bytes) / 1e6);
  if (source.malformed() > 0)
    std::cout << fmt::format("  {} frames were malformed or missing\n", source.malformed());
  return counts.frames > 0 ? 0 : 1;
}

int write(const LandmarkRecording& recording, const std::string& log) {
  for (const auto& note : recording.notes) std::cout << "  " << note << "\n";
  for (const auto& problem : recording.problems) std::cout << "  " << problem << "\n";
  const LandmarkLogCounts counts = write_landmark_log(recording, log);
  std::cout << fmt::format(
      "  {}: {} frames with {} landmark observations, {} motions, {} true poses, {:.1f} MB\n", log,
      counts.frames, counts.features, counts.motions, counts.truths, static_cast<double>(counts.bytes) / 1e6);
  return counts.frames > 0 ? 0 : 1;
}

}  // namespace

int import_command(int argc, char** argv) {
  std::string folder, log, calibration, description;
  int robot = 0;
  CLI::App app{"Turns a data set folder into an .lcmlog that lcm-logplayer replays.", "lcmslam import"};
  app.add_option("folder", folder,
                 "TUM RGB-D, 7-Scenes, numbered images or UTIAS MRCLAM; or the file victoria_park.txt")
      ->required()
      ->check(CLI::ExistingPath);
  app.add_option("log", log, "file to write")->required();
  app.add_option("--calibration", calibration, "camera calibration (YAML)")->check(CLI::ExistingFile);
  app.add_option("--description", description, "layout of the folder (YAML, see config/datasets)")
      ->check(CLI::ExistingFile);
  app.add_option("--robot", robot, "of an MRCLAM folder")->check(CLI::Range(1, 5));
  int passes = 1;
  app.add_option("--repeat", passes, "the recording so many times, times shifted on: for endurance tests")
      ->check(CLI::Range(1, 1000));
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  DatasetOptions options;
  options.description = description;
  if (const auto recording = open_landmark_dataset(folder, robot, options)) return write(*recording, log);
  ConfigNode config;
  config.set("folder", folder);
  if (!calibration.empty()) config.set("calibration", calibration);
  if (!description.empty()) config.set("description", description);
  return write(*repeat_source([&] { return make_dataset_source(config); }, passes), log);
}

int simulate_command(int argc, char** argv) {
  std::string scene, log, head = "tof", base = "differential";
  int seed = 1;
  double seconds = 0;
  CLI::App app{"Renders a simulated run into an .lcmlog.", "lcmslam simulate"};
  app.add_option("scene", scene, "scene (YAML), e.g. config/scenes/kitchen.yaml")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("log", log, "file to write")->required();
  app.add_option("--head", head, "tof or rgbd");
  app.add_option("--base", base, "differential, steered or mecanum");
  app.add_option("--seed", seed, "of the sensors' errors");
  app.add_option("--seconds", seconds, "only the first so many seconds");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  ConfigNode config;
  config.set("scene", std::filesystem::absolute(scene).lexically_normal());
  config.set("head", head);
  config.set("base", base);
  config.set("seed", std::to_string(seed));
  config.set("seconds", std::to_string(seconds));
  config.set("threads", "2");
  return write(*make_live_simulation(config), log);
}

}  // namespace lcmslam
