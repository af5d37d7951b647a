#include "tools/config/setting_sections.hpp"

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/runtime/launch_settings.hpp>
#include <lcmslam/runtime/options.hpp>
#include "procs/bridge/bridge_node.hpp"
#include "procs/camera/camera_node.hpp"
#include "procs/fastslam/fastslam_node.hpp"
#include "procs/icp/icp_node.hpp"
#include "procs/map-server/map_server_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "procs/surf/surf_node.hpp"

namespace lcmslam {
namespace {

template <class N>
SettingSection section_of(const char* process, const char* meaning) {
  return {process, meaning, list_settings(typename N::Settings()), {}, [](const ConfigNode& section) {
            N::read(section);
          }};
}

SettingSection launch_section() {
  return {"launch",
          "which processes make the graph",
          list_settings(LaunchSettings()),
          {},
          [](const ConfigNode& section) { read_settings<LaunchSettings>(section); }};
}

SettingSection fastslam_section() {
  SettingSection section =
      section_of<FastSlamNode>("fastslam", "FEATURES and ODOMETRY become a landmark map");
  section.presets = {{"thesis", list_settings(FastSlamNode::read(ConfigNode::parse("{preset: thesis}")))}};
  return section;
}

}  // namespace

const std::vector<SettingSection>& setting_sections() {
  static const std::vector<SettingSection> sections = {
      launch_section(),
      section_of<CameraNode>("camera", "a source becomes CAMERA and CAMERA_CALIBRATION"),
      section_of<SurfNode>("surf", "CAMERA becomes FEATURES"),
      section_of<OdometryNode>("odometry",
                               "wheels, velocities, features or another driver's pose become ODOMETRY"),
      fastslam_section(),
      section_of<IcpNode>("icp", "CAMERA, FEATURES and ODOMETRY become a dense map"),
      section_of<MapServerNode>("map-server", "keeps both maps, answers questions to them, saves them"),
      section_of<BridgeNode>("bridge", "chosen channels go to an MQTT broker and come from it (ROBOTS.md)")};
  return sections;
}

std::string SettingSection::defaults(const SettingEntry& entry) const {
  if (entry.required) return "none: must be given";
  std::string text = entry.value, others;
  for (const auto& [preset, values] : presets)
    for (const SettingEntry& other : values)
      if (other.path == entry.path && other.value != entry.value && entry.path != "preset")
        others += (others.empty() ? "" : ", ") + preset + ": " + other.value;
  return others.empty() ? text : text + " (" + others + ")";
}

}  // namespace lcmslam
