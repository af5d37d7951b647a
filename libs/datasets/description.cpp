#include <lcmslam/datasets/description.hpp>

#include <algorithm>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/datasets/numbered_files.hpp>
#include <lcmslam/datasets/readers.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

void read_numbered(const ConfigNode& config, Description& description) {
  description.colour = config.text("colour");
  description.depth = config.text("depth");
  for (const auto& [key, pattern] : {std::pair{"colour", &description.colour}, {"depth", &description.depth}})
    if (!NumberedFiles::is_pattern(*pattern))
      config.fail(key, "'" + *pattern + "' must hold one number, like image/%05d.jpg");
  description.stamps = config.get("stamps", "");
  if (config.has("poses")) {
    const ConfigNode poses = config.section("poses");
    description.poses = poses.text("file");
    description.pose_format = poses.choice("format", "tum", {"tum", "quaternions", "matrices", "log"});
  }
}

void read_tum(const ConfigNode& config, Description& description) {
  description.max_stamp_difference =
      config.get("max_stamp_difference", description.max_stamp_difference, Range{0, 1});
  const ConfigNode by_name = config.section("calibration_by_name");
  for (const std::string& name : by_name.keys())
    description.calibration_by_name.emplace_back(name, by_name.folder(name) / by_name.text(name));
}

bool without_images(const Description& description) {
  return description.format == "mrclam" || description.format == "victoria_park";
}

std::vector<fs::path> shipped_descriptions(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Which pattern no file fits; empty: each is fitted, or there is none.
std::string unfitted_pattern(const Description& description, const fs::path& folder) {
  if (description.format != "numbered") return "";
  const std::string colour = why_no_file_fits(folder, description.colour);
  return colour.empty() ? why_no_file_fits(folder, description.depth) : colour;
}

Description checked(Description description, const fs::path& folder) {
  const std::string unfitted = unfitted_pattern(description, folder);
  if (!unfitted.empty()) throw DatasetError(description.file.string() + ": " + unfitted);
  return description;
}

}  // namespace

Description read_description(const fs::path& file) {
  const ConfigNode config = ConfigNode::load(file);
  Description description;
  description.file = file;
  if (!config.has("format"))
    config.fail("format", "the key format is missing: tum, seven_scenes or numbered");
  description.format =
      config.choice("format", "tum", {"tum", "seven_scenes", "numbered", "mrclam", "victoria_park"});
  if (without_images(description)) return description;  // landmark_recording.hpp reads the rest
  description.depth_scale = config.get("depth_scale", description.depth_scale, Range{1, 1e6});
  description.frame_rate = config.get("frame_rate", description.frame_rate, Range{1e-3, 1e9});
  description.truth_of = config.choice("truth_of", description.truth_of, {"colour", "depth", "robot"});
  if (config.has("calibration"))
    description.calibration = config.folder("calibration") / config.text("calibration");
  if (description.format == "numbered") read_numbered(config, description);
  if (description.format == "tum") read_tum(config, description);
  config.finish();
  return description;
}

bool matches(const Description& description, const fs::path& folder) {
  if (without_images(description)) return false;
  if (description.format == "tum") return is_tum(folder);
  if (description.format == "seven_scenes") return is_seven_scenes(folder);
  return !NumberedFiles(folder, description.colour).numbers().empty() &&
         !NumberedFiles(folder, description.depth).numbers().empty() &&
         (description.poses.empty() || fs::exists(folder / description.poses));
}

Description find_description(const fs::path& folder, const DatasetOptions& options,
                             const fs::path& config_folder) {
  if (!options.description.empty()) {
    Description description = checked(read_description(options.description), folder);
    if (!matches(description, folder))
      throw DatasetError(folder.string() + ": does not hold the files that " + options.description.string() +
                         " describes");
    return description;
  }
  if (fs::exists(folder / "lcmslam.yaml")) return checked(read_description(folder / "lcmslam.yaml"), folder);
  for (const fs::path& file : shipped_descriptions(config_folder / "datasets")) {
    Description description = read_description(file);
    if (matches(description, folder)) return description;
  }
  throw DatasetError(folder.string() +
                     ": no known layout; expected rgb.txt and depth.txt (TUM), frame-000000.color.png or "
                     "seq-01 (7-Scenes), files that one of " +
                     (config_folder / "datasets").string() +
                     "/*.yaml describes, or an lcmslam.yaml that describes them (see there)");
}

}  // namespace lcmslam
