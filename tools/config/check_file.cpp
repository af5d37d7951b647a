#include "tools/config/check_file.hpp"

#include <lcmslam/datasets/description.hpp>
#include <lcmslam/datasets/landmark_recording.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/imaging/io/foreign_calibration.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/simulation/scene.hpp>
#include "tools/config/setting_sections.hpp"

namespace lcmslam {
namespace {

void check_description(const std::filesystem::path& file) {
  const std::string format = read_description(file).format;
  if (format == "mrclam") load_mrclam_sensor(file);
  if (format == "victoria_park") load_victoria_park_settings(file);
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
  if (config.has("colour") || config.has("depth") || config.has("depth_registered")) {
    load_calibration(file);
    return "a calibration";
  }
  check_graph(file.string(), overrides);
  return config.has("launch") ? "a graph" : "a preset";
}

}  // namespace lcmslam
