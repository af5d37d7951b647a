#include <fmt/format.h>
#include <filesystem>
#include <iostream>
#include <optional>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include <lcmslam/self_calibration/recorded_scene.hpp>
#include <lcmslam/self_calibration/self_calibration_text.hpp>
#include "tools/calibrate/calibrate_commands.hpp"
#include "tools/log/message_reader.hpp"
#include "tools/output_file.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

struct SelfOptions {
  std::string log, output, start;
  bool force = false;
  double rate = 0, seconds = 0;
  CalibrationPriors priors;
  RecordedSceneSettings scene;
  BundleSettings bundle;
};

/// The frames of a log, as its calibration or the given one understands them.
std::unique_ptr<RecordedScene> read_log(const SelfOptions& options, RgbdCalibration& start) {
  std::optional<RgbdCalibration> calibration;
  if (!options.start.empty()) calibration = load_calibration(options.start);
  std::unique_ptr<RecordedScene> recording;
  MessageReader reader(options.log);
  Utime first = 0, last = 0;
  int malformed = 0;
  while (const auto event = reader.next()) {
    throw_when_stopped();
    try {
      if (event->channel == "CAMERA_CALIBRATION" && !calibration)
        calibration = from_message(decode_message<camera_calibration_t>(event->data, event->size));
      if (event->channel != "CAMERA" || !calibration) continue;
      const auto message = decode_message<images_t>(event->data, event->size);
      if (first == 0) first = message.utime;
      if (options.seconds > 0 && 1e-6 * static_cast<double>(message.utime - first) > options.seconds) break;
      if (options.rate > 0 && last != 0 &&
          1e-6 * static_cast<double>(message.utime - last) < 0.75 / options.rate)
        continue;
      last = message.utime;
      if (!recording) recording = std::make_unique<RecordedScene>(*calibration, options.scene);
      recording->add(decode_images(message, *calibration));
    } catch (const DecodeError&) {
      ++malformed;
    }
  }
  if (!calibration)
    throw std::runtime_error(options.log +
                             ": has no CAMERA_CALIBRATION to begin with; --start FILE gives one");
  if (!recording)
    throw std::runtime_error(options.log + ": has no CAMERA images of that calibration's sizes");
  if (malformed > 0) std::cout << "  " << malformed << " messages were malformed\n";
  start = *calibration;
  return recording;
}

}  // namespace

int calibrate_self_command(int argc, char** argv) {
  SelfOptions o;
  CLI::App app{
      "Refines a camera head's calibration from any recording, without a board: focal length, principal "
      "point, "
      "distortion, the depth camera's place, scale, offset and clock, and the rolling shutter.",
      "lcmslam calibrate self"};
  app.add_option("log", o.log, "an .lcmlog with CAMERA")->required()->check(CLI::ExistingFile);
  app.add_option("output", o.output, "calibration (YAML) to write");
  app.add_flag("--force", o.force, "overwrite the output if it exists");
  app.add_option("--start", o.start, "calibration (YAML) to begin with, in the place of the log's own")
      ->check(CLI::ExistingFile);
  app.add_option("--rate", o.rate, "Hz of the images that are used, at most; 0: all")
      ->check(CLI::Range(0.0, 1000.0));
  app.add_option("--seconds", o.seconds, "of the log, from its start; 0: all")->check(CLI::Range(0.0, 1e6));
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (!o.output.empty()) check_output_file(o.output, o.force);
  install_stop_signals(0);

  RgbdCalibration start;
  const auto recording = read_log(o, start);
  SceneObservations scene = recording->observations();
  std::cout << fmt::format("{}: {} of {} frames tracked, {} keyframes, {} landmarks\n", o.log,
                           recording->tracked(), recording->frames(), scene.keyframes.size(),
                           scene.landmarks.size());
  HeadModel model(start);
  const BundleResult result = adjust_bundle(model, scene, o.priors, o.bundle);
  std::cout << fmt::format(
                   "  {} pixels within {:.2f} pixels, {} depths within {:.2f} of the sensor's noise\n",
                   result.pixels, result.pixel_scale, result.depths, result.depth_scale)
            << report_text(model, result, o.bundle);
  if (o.output.empty()) return 0;
  model.calibration().check();
  write_atomically(std::filesystem::path(o.output),
                   calibration_yaml(model, result, "Refined from " + o.log + " by lcmslam calibrate self."));
  std::cout << o.output << " is written\n";
  return 0;
}

}  // namespace lcmslam
