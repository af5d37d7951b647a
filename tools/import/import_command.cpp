#include <fmt/format.h>
#include <iostream>

#include <lcmslam/datasets/problem_summary.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "procs/camera/camera_log.hpp"
#include "procs/camera/repeated_source.hpp"
#include "tools/commands.hpp"
#include "tools/import/applicable_options.hpp"
#include "tools/import/landmark_log.hpp"
#include "tools/import/ros_log.hpp"
#include "tools/log/log_plausibility.hpp"
#include "tools/output_file.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

int write(CameraSource& source, const std::string& log) {
  for (const auto& note : source.notes()) std::cout << "  " << note << "\n";
  const LogCounts counts = write_log(source, log, throw_when_stopped);
  std::cout << fmt::format("  {}: {} frames, {} encoder readings, {} true poses, {:.1f} MB\n", log,
                           counts.frames, counts.encoders, counts.truths,
                           static_cast<double>(counts.bytes) / 1e6);
  if (source.malformed() > 0)
    std::cout << fmt::format("  {} frames were malformed or missing\n", source.malformed());
  for (const auto& warning : source.warnings()) std::cout << "  " << warning << "\n";
  if (counts.frames > 0) std::cout << format_plausibility(plausibility_of_log(log));
  return 0;
}

int write(const LandmarkRecording& recording, const std::string& log) {
  for (const auto& note : recording.notes) std::cout << "  " << note << "\n";
  for (const auto& problem : summarise_problems(recording.problems)) std::cout << "  " << problem << "\n";
  const LandmarkLogCounts counts = write_landmark_log(recording, log);
  std::cout << fmt::format(
      "  {}: {} frames with {} landmark observations, {} motions, {} true poses, {:.1f} MB\n", log,
      counts.frames, counts.features, counts.motions, counts.truths, static_cast<double>(counts.bytes) / 1e6);
  return 0;
}

int write(ros::RosRecording& recording, bool odometry_as_twist, const std::string& log) {
  std::cout << fmt::format("  {} frames\n", recording.frames());
  for (const auto& note : recording.notes()) std::cout << "  " << note << "\n";
  std::cout << "  " << describe(recording.calibration()) << "\n";
  const RosLogCounts counts = write_ros_log(recording, odometry_as_twist, log, throw_when_stopped);
  std::cout << fmt::format("  {}: {} frames, {} odometry readings on {}, {} true poses, {:.1f} MB\n", log,
                           counts.frames, counts.odometry, odometry_as_twist ? "TWIST" : "POSE_BODY",
                           counts.truths, static_cast<double>(counts.bytes) / 1e6);
  for (const auto& problem : summarise_problems(recording.problems())) std::cout << "  " << problem << "\n";
  std::cout << format_plausibility(plausibility_of_log(log));
  return 0;
}

/// What is asked of recordings of ROS alone.
struct RosInput {
  ros::RosOptions options;
  bool odometry_as_twist = false;

  void add_to(CLI::App& app) {
    ros::Topics& topics = options.topics;
    const auto add = [&](const char* name, std::string& topic, const char* help) {
      app.add_option(name, topic, help)->group(ros_group);
    };
    add("--colour-topic", topics.colour,
        "images of the colour camera (default: by type and name, as the rest)");
    add("--depth-topic", topics.depth, "images of the depth camera");
    add("--colour-info-topic", topics.colour_info, "CameraInfo of the colour camera");
    add("--depth-info-topic", topics.depth_info, "CameraInfo of the depth camera");
    add("--odometry-topic", topics.odometry, "nav_msgs/Odometry");
    add("--truth-topic", topics.truth,
        "true poses of the robot (Odometry, PoseStamped), for evaluation only");
    app.add_flag("--twist", odometry_as_twist, "take the velocities of the odometry, not its poses")
        ->group(ros_group);
    app.add_option("--max-stamp-difference", options.max_stamp_difference,
                   "s between a colour image and its depth image")
        ->check(CLI::Range(0.0, 1.0))
        ->group(ros_group);
  }
};

/// The log that a command writes.
struct Output {
  std::string file;
  bool force = false;

  void add_to(CLI::App& app) {
    app.add_option("log", file, "file to write")->required();
    app.add_flag("--force", force, "overwrite the log if it exists");
  }
  void begin() const {
    check_output_file(file, force);
    install_stop_signals(0);
  }
};

}  // namespace

int import_command(int argc, char** argv) {
  std::string folder, calibration, description;
  Output output;
  int robot = 0;
  CLI::App app{
      "Turns a data set folder, a ROS bag or an MCAP file into an .lcmlog that lcm-logplayer replays.",
      "lcmslam import"};
  app.add_option(
         "folder", folder,
         "TUM RGB-D, 7-Scenes, numbered images or UTIAS MRCLAM; a .bag or .mcap file or a folder of them "
         "(docs/ROS.md); or the file victoria_park.txt")
      ->required()
      ->check(CLI::ExistingPath);
  output.add_to(app);
  app.add_option("--calibration", calibration,
                 "camera calibration (YAML): ours, ROS's camera_info or OpenCV's")
      ->check(CLI::ExistingFile);
  app.add_option("--description", description, "layout of the folder (YAML, see config/datasets)")
      ->check(CLI::ExistingFile);
  app.add_option("--robot", robot, "of an MRCLAM folder")->check(CLI::Range(1, 5));
  int passes = 1;
  app.add_option("--repeat", passes, "the recording so many times, times shifted on: for endurance tests")
      ->check(CLI::Range(1, 1000));
  RosInput ros_input;
  ros_input.add_to(app);
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  output.begin();
  if (const auto files = ros::ros_files(folder); !files.empty()) {
    check_applicable(app, RecordingKind::ros, folder);
    ros_input.options.calibration = calibration;
    ros::RosRecording recording(files, ros_input.options);
    return write(recording, ros_input.odometry_as_twist, output.file);
  }
  DatasetOptions options;
  options.description = description;
  if (const auto recording = open_landmark_dataset(folder, robot, options)) {
    const bool mrclam = !mrclam_robots(folder).empty();
    check_applicable(app, mrclam ? RecordingKind::mrclam : RecordingKind::victoria_park, folder);
    return write(*recording, output.file);
  }
  check_applicable(app, RecordingKind::images, folder);
  DatasetSourceSettings settings;
  settings.folder = folder;
  settings.calibration = calibration;
  settings.description = description;
  return write(*repeat_source([&] { return make_dataset_source(settings); }, passes), output.file);
}

int simulate_command(int argc, char** argv) {
  SimulationSourceSettings source;
  SimulationSettings& simulation = source.simulation;
  std::string scene;
  Output output;
  CLI::App app{"Renders a simulated run into an .lcmlog.", "lcmslam simulate"};
  app.add_option("scene", scene, "scene (YAML), e.g. config/scenes/kitchen.yaml")
      ->required()
      ->check(CLI::ExistingFile);
  output.add_to(app);
  app.add_option("--head", simulation.head, "tof, rgbd, or one of config/heads: its name or its file");
  app.add_option("--unit", simulation.unit, "which piece of that head; 0: as described");
  app.add_option("--base", simulation.base, "differential, steered or mecanum");
  app.add_option("--seed", simulation.seed, "of the sensors' errors");
  app.add_option("--seconds", simulation.seconds, "only the first so many seconds");
  app.add_option("--rate", simulation.frame_rate,
                 "frames a second (default: the head's own; 10 for tof, 30 for rgbd)")
      ->check(CLI::Range(0.0, 200.0));
  CameraFaults& faults = simulation.faults;
  app.add_option("--rolling-shutter", faults.rolling_shutter,
                 "s from the colour image's first row to its last")
      ->check(CLI::Range(0.0, 0.1));
  app.add_option("--exposure-adaptation", faults.exposure_adaptation,
                 "s in which the exposure follows the light (default: it stays)")
      ->check(CLI::Range(0.0, 60.0));
  app.add_option("--image-stamp-error", faults.image_stamp_error, "s, of both images' stamps, told to nobody")
      ->check(CLI::Range(-1.0, 1.0));
  app.add_option("--depth-stamp-error", faults.depth_stamp_error,
                 "s, of depth's stamps besides, told to nobody")
      ->check(CLI::Range(-1.0, 1.0));
  app.add_option("--stamp-jitter", faults.stamp_jitter, "s, of each image's stamp at most")
      ->check(CLI::Range(0.0, 0.1));
  app.add_option("--jpeg-quality", source.jpeg_quality, "of the colour images; less makes smaller logs")
      ->check(CLI::Range(1, 100));
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  output.begin();
  simulation.scene = std::filesystem::absolute(scene).lexically_normal();
  simulation.threads = 2;
  return write(*make_live_simulation(source), output.file);
}

}  // namespace lcmslam
