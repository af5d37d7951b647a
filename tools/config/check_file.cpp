#include "tools/config/check_file.hpp"

#include <algorithm>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/datasets/description.hpp>
#include <lcmslam/datasets/landmark_recording.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/imaging/io/foreign_calibration.hpp>
#include <lcmslam/runtime/launch_settings.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/simulation/head_settings.hpp>
#include <lcmslam/simulation/scene.hpp>
#include "procs/camera/camera_source.hpp"
#include "tools/config/setting_sections.hpp"

namespace lcmslam {
namespace {

void check_description(const std::filesystem::path& file) {
  const std::string format = read_description(file).format;
  if (format == "mrclam") load_mrclam_sensor(file);
  if (format == "victoria_park") load_victoria_park_settings(file);
}

/// What only a head of the simulation has.
bool is_head(const ConfigNode& config) {
  for (const char* key : {"kind", "faults", "triangulation", "time_of_flight", "frame_rate"})
    if (config.has(key)) return true;
  return false;
}

void check_graph(const std::string& file, const std::vector<std::string>& overrides) {
  const ConfigNode config = load_config(file, overrides);
  for (const SettingSection& section : setting_sections())
    if (config.has(section.name)) section.read(config.section(section.name));
  config.finish();
}

}  // namespace

std::string check_file(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const ConfigNode config = load_calibration_yaml(file);
  if (is_foreign_camera(config)) {
    load_calibration(file);
    return "a camera's calibration of ROS or OpenCV";
  }
  if (config.has("rooms")) {
    load_scene(file);
    return "a scene";
  }
  if (config.has("format")) {
    check_description(file);
    return "a data set's description";
  }
  if (is_head(config)) {
    load_head(file);
    return "a sensor head";
  }
  if (config.has("colour") || config.has("depth") || config.has("depth_registered")) {
    load_calibration(file);
    return "a calibration";
  }
  check_graph(file.string(), overrides);
  return config.has("launch") ? "a graph" : "a preset";
}

std::vector<std::string> missing_files(const std::filesystem::path& file,
                                       const std::vector<std::string>& overrides) {
  const ConfigNode config = load_config(file.string(), overrides);
  if (!config.has("launch") || !config.has("camera")) return {};
  const auto processes = read_settings<LaunchSettings>(config.section("launch")).processes;
  if (std::find(processes.begin(), processes.end(), "camera") == processes.end()) return {};
  const ConfigNode camera = config.section("camera");
  const CameraSettings settings = read_camera_settings(camera);
  std::vector<std::string> missing;
  const auto need = [&](const std::string& section, const std::string& key,
                        const std::filesystem::path& path) {
    std::error_code error;
    if (path.empty() || std::filesystem::exists(path, error)) return;
    missing.push_back(camera.section(section).where(key) + ": '" + key + "' names " + path.string() +
                      ", which is not there");
  };
  if (settings.source == "simulation") need("simulation", "scene", settings.simulation.simulation.scene);
  if (settings.source == "dataset") need("dataset", "folder", settings.dataset.folder);
  if (settings.source == "log") need("log", "file", settings.log.file);
  if (settings.source == "calibration") need("calibration", "file", settings.calibration.file);
  if (settings.is_live_kind()) need("live", "calibration", settings.live.calibration);
  return missing;
}

}  // namespace lcmslam
