#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/configuration/share.hpp>
#include <lcmslam/datasets/description.hpp>
#include <lcmslam/datasets/landmark_recording.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

fs::path description_of(const std::string& format, const DatasetOptions& options) {
  const fs::path folder = options.config_folder.empty() ? share_path("config") : options.config_folder;
  return options.description.empty() ? folder / "datasets" / (format + ".yaml") : options.description;
}

ConfigNode load_description(const fs::path& file, const std::string& format) {
  const ConfigNode config = ConfigNode::load(file);
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

MrclamSensor load_mrclam_sensor(const fs::path& description) {
  const ConfigNode config = load_description(description, "mrclam");
  const auto sensor = read_settings<MrclamSensor>(config.section("sensor"));
  config.finish();
  return sensor;
}

VictoriaParkSettings load_victoria_park_settings(const fs::path& description) {
  const ConfigNode config = load_description(description, "victoria_park");
  const auto settings = read_settings<VictoriaParkSettings>(config);
  config.finish();
  return settings;
}

std::optional<LandmarkRecording> open_landmark_dataset(const fs::path& path, int robot,
                                                       const DatasetOptions& options) {
  if (const std::vector<int> robots = mrclam_robots(path); !robots.empty()) {
    const MrclamSensor sensor = load_mrclam_sensor(description_of("mrclam", options));
    return read_mrclam(path, choose_robot(path, robots, robot), sensor);
  }
  const fs::path file = fs::is_directory(path) ? path / "victoria_park.txt" : path;
  if (!is_victoria_park(file)) return std::nullopt;
  return read_victoria_park(file, load_victoria_park_settings(description_of("victoria_park", options)));
}

}  // namespace lcmslam
