#include <lcmslam/configuration/share.hpp>
#include <lcmslam/datasets/description.hpp>
#include <lcmslam/datasets/landmark_recording.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

ConfigNode load_description(const std::string& format, const DatasetOptions& options) {
  const fs::path folder = options.config_folder.empty() ? share_path("config") : options.config_folder;
  const ConfigNode config = ConfigNode::load(
      options.description.empty() ? folder / "datasets" / (format + ".yaml") : options.description);
  if (config.choice("format", format, {"mrclam", "victoria_park"}) != format)
    config.fail("format", "the data are of the format " + format);
  return config;
}

int choose_robot(const fs::path& folder, const std::vector<int>& robots, int wanted) {
  std::string there;
  for (const int robot : robots) {
    if (robot == wanted || (wanted == 0 && robots.size() == 1)) return robot;
    there += (there.empty() ? "" : ", ") + std::to_string(robot);
  }
  throw DatasetError(folder.string() + ": " +
                     (wanted == 0 ? "which robot?" : "no robot " + std::to_string(wanted)) +
                     " There are: " + there);
}

}  // namespace

std::optional<LandmarkRecording> open_landmark_dataset(const fs::path& path, int robot,
                                                       const DatasetOptions& options) {
  if (const std::vector<int> robots = mrclam_robots(path); !robots.empty()) {
    const ConfigNode config = load_description("mrclam", options);
    const MrclamSensor sensor = read_mrclam_sensor(config.section("sensor"));
    config.finish();
    return read_mrclam(path, choose_robot(path, robots, robot), sensor);
  }
  const fs::path file = fs::is_directory(path) ? path / "victoria_park.txt" : path;
  if (!is_victoria_park(file)) return std::nullopt;
  const ConfigNode config = load_description("victoria_park", options);
  const VictoriaParkSettings settings = read_victoria_park_settings(config);
  config.finish();
  return read_victoria_park(file, settings);
}

}  // namespace lcmslam
