#include <fmt/format.h>
#include <iostream>

#include <lcmslam/calibration/self/drive_advice.hpp>
#include <lcmslam/calibration/self/head_calibration.hpp>
#include <lcmslam/calibration/self/self_report.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/calibrate/calibrate_commands.hpp"
#include "tools/calibrate/calibration_output.hpp"
#include "tools/calibrate/recorded_head.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {

int calibrate_self_command(int argc, char** argv) {
  std::string log;
  CalibrationOutput output;
  RecordedHeadOptions options;
  CLI::App app{
      "A camera head from any recording, without a board: focal length, distortion, the depth camera's "
      "place, "
      "scale, offset and clock, and the rolling shutter. Says what the recording does not tell.",
      "lcmslam calibrate self"};
  app.add_option("log", log,
                 "an .lcmlog with CAMERA; ENCODERS or ODOMETRY help where the calibration has a mount")
      ->required()
      ->check(CLI::ExistingFile);
  output.add_to(app, "calibration (YAML) to write");
  app.add_option("--rate", options.rate,
                 "Hz of the images that are used, at most, 4 or more; 0 (the default): all")
      ->check(CLI::Range(0.0, 1000.0));
  app.add_option("--seconds", options.seconds, "of the log, from its start; 0 (the default): all")
      ->check(CLI::Range(0.0, 1e6));
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (options.rate > 0 && options.rate < RecordedScene::slowest_images)
    throw std::invalid_argument(
        fmt::format("--rate {:g}: so few images do not tell how fast the camera moves; give {:g} Hz or more, "
                    "or 0 for all",
                    options.rate, RecordedScene::slowest_images));
  output.check();
  install_stop_signals(0);

  const RecordedHead recorded = read_head(log, output.base(std::nullopt), options);
  if (recorded.scene->wheels_lack_mount())
    advise({"wheels are not used: the calibration has no mount, which calibrate mount finds"});
  SceneObservations scene = recorded.scene->observations();
  std::cout << fmt::format("{}: {} of {} images tracked, {} keyframes, {} landmarks\n", log,
                           recorded.scene->tracked(), recorded.scene->frames(), scene.keyframes.size(),
                           scene.landmarks.size());
  if (recorded.damaged > 0) std::cout << fmt::format("  {} messages were damaged\n", recorded.damaged);
  HeadModel model(recorded.start);
  const BundleSettings settings;
  const BundleResult result = calibrate_head(model, scene, {}, settings);
  std::cout << fmt::format(
                   "  {} pixels within {:.2f} pixels, {} depths within {:.2f} of the sensor's noise\n",
                   result.pixels, result.pixel_scale, result.depths, result.depth_scale)
            << report_text(model, result, settings);
  advise(drive_advice(model, result, scene.keyframes.size(),
                      static_cast<std::size_t>(RecordedSceneSettings().keyframes)));
  if (const int refused = refuse(self_doubts(result, settings, scene.keyframes.size()), output.accept))
    return refused;
  output.write(observed_head(model, result, settings).calibration(),
               "Refined from " + log + " by lcmslam calibrate self.", self_covariance_text(result));
  return 0;
}

}  // namespace lcmslam
