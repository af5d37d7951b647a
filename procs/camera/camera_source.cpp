#include "procs/camera/camera_source.hpp"

#include <lcmslam/configuration/read_settings.hpp>
#include "procs/camera/camera_log.hpp"

namespace lcmslam {

Utime event_utime(const CameraEvent& event) {
  return std::visit([](const auto& e) { return e.utime; }, event);
}

CameraSettings read_camera_settings(const ConfigNode& config) {
  auto settings = read_settings<CameraSettings>(config);
  std::filesystem::path& scene = settings.simulation.simulation.scene;
  if (settings.source == "simulation" && scene.is_relative())
    scene = config.section("simulation").folder("scene") / scene;
  std::filesystem::path& calibration = settings.calibration.file;
  if (settings.source == "calibration" && calibration.is_relative())
    calibration = config.section("calibration").folder("file") / calibration;
  if (settings.is_live_kind() && settings.live.calibration.is_relative())
    settings.live.calibration = config.section("live").folder("calibration") / settings.live.calibration;
  return settings;
}

std::unique_ptr<CameraSource> make_camera_source(const CameraSettings& settings) {
  if (settings.source == "dataset") return make_dataset_source(settings.dataset);
  if (settings.source == "log") return open_log(settings.log.file);
  if (settings.source == "calibration") return make_calibration_source(settings.calibration);
  if (settings.source == "channel") return make_channel_source(settings.channel, settings.live);
  if (settings.is_device())
    throw std::runtime_error("camera.source: " + settings.source + " is opened by the process camera alone");
  return make_simulation_source(settings.simulation);
}

}  // namespace lcmslam
